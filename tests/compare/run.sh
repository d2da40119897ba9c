#!/bin/sh
# Compares MeshLab's own reconstruction filters with ours: sh tests/compare/run.sh [CLOUDS] [options, --help lists them]
#
# Installs what is missing (apt, with sudo when not root), builds, reconstructs every cloud with Ball Pivoting, Screened
# Poisson and Shrink Wrap in the same meshlabserver, measures the results, and writes comparison.html, comparison.md and
# pictures to tests/compare/results. Pictures need python3-vtk9, which is not installed for you.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/cmake/setup.sh"

case " $* " in
  *" --help "* | *" -h "*) exec python3 "$root/tests/compare/run.py" --help ;;
esac

# shellcheck disable=SC2086  # lists of words
require_packages $host_packages $test_packages
configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=ON
compile "$build" filter_shrinkwrap_recon add_noise make_truth

exec python3 "$root/tests/compare/run.py" --build "$build" --renderer "$(python_with vtk)" "$@"
