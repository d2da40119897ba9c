#!/bin/sh
# Measures the reconstruction: sh tests/benchmark/run.sh [options of run.py, --help lists them]
#
# Installs what is missing (apt, with sudo when not root), builds, and measures up to 1,000,000 samples (--full: up to
# 10,000,000). Writes benchmark.md, benchmark.svg and the raw figures to tests/benchmark/results.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/cmake/setup.sh"

case " $* " in
  *" --help "* | *" -h "*) exec python3 "$root/tests/benchmark/run.py" --help ;;
esac

# shellcheck disable=SC2086  # lists of words
require_packages $host_packages $test_packages python3-matplotlib
configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=ON
compile "$build" benchmarks filter_shrinkwrap_recon

exec "$(python_with matplotlib)" "$root/tests/benchmark/run.py" --build "$build" "$@"
