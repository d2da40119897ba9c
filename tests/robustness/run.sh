#!/bin/sh
# Looks for clouds that go wrong: sh tests/robustness/run.sh [COUNT] [SEED]
#
# COUNT generated clouds (5000 unless told), a fifth as many damaged files and the whole gallery of degenerate clouds,
# each reconstructed in a process of its own, then a table of what was wrong with which. Leaves with an error if a promise
# was broken or a cloud that resolves its object came out wrong. Any of them again, with its points in a file:
#     build/tests/robustness/robustness --case clouds:1000003 --write cloud.ply
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/cmake/setup.sh"

usage() { sed -n '2,/^set -eu/s/^# \{0,1\}//p' "$0"; }
is_number() {
  case $1 in '' | 0?* | *[!0-9]* | ????????????*) return 1 ;; esac
}

case " $* " in
  *" --help "* | *" -h "*)
    usage
    exit 0
    ;;
esac
count=${1:-5000}
seed=${2:-1}
if [ $# -gt 2 ] || ! is_number "$count" || ! is_number "$seed"; then
  usage >&2
  die "COUNT and SEED are numbers, not: $*"
fi
# shellcheck disable=SC2086  # lists of words
require_packages $host_packages $test_packages
configure "$build" -DSHRINKWRAP_BUILD_TESTS=ON
compile "$build" robustness
exec "$build/tests/robustness/robustness" clouds "$count" files $((count / 5)) gallery 1000000 --seed "$seed" \
  --jobs "$(nproc)" --time-limit 1 --log "$build/robustness_$seed.jsonl"
