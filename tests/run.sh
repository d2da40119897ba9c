#!/bin/sh
# Runs the tests, but for two that are run by hand (README.md): sh tests/run.sh [ctest options]
#
# Installs what is missing (apt, with sudo when not root), fetches MeshLab's headers, builds, and runs the unit tests
# and the tests on the real MeshLab.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/cmake/setup.sh"

# shellcheck disable=SC2086  # lists of words
require_packages $host_packages $test_packages
configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=ON -DSHRINKWRAP_WARNINGS_AS_ERRORS=ON
compile "$build"
cd "$build"
exec ctest --output-on-failure --parallel "$(nproc)" "$@"
