#!/bin/sh
# Runs the plugin on newer MeshLabs than the one installed, without touching this system.
#
#   sh tests/newer_meshlab/run.sh [--suites "unstable trixie"] [--mirror URL] [--cloud FILE] [--keep]
#
# --suites   Debian suites whose MeshLab is tried (default: unstable, MeshLab 2025.07, and trixie, MeshLab 2022.02)
# --mirror   archive to take them from (default: the one that this machine's own apt sources name)
# --cloud    the cloud that is reconstructed (default: the cactus of the sample clouds)
# --keep     leave the chroots where they are (<build>/newer_meshlab/<suite>): the next run is quick
#
# For each suite: makes a chroot with debootstrap, builds the plugin in it against that release's own source package,
# as float and as double (compiled only), does with it what PyMeshLab does, compares its mesh byte for byte with that
# of the MeshLab installed here, then starts the real MeshLab under Xvfb, applies the filter from its search box, and
# keeps pictures. Needs root and the network; without, it says so and leaves with 0, since nothing was found wrong.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/cmake/setup.sh"

suites="unstable trixie" mirror='' keep='' cloud=$root/sample_clouds/cactus_3280.ply
while [ $# -gt 0 ]; do
  case $1 in
    --suites | --mirror | --cloud)
      [ $# -gt 1 ] || die "$1 needs a value"
      case $1 in
        --suites) suites=$2 ;;
        --mirror) mirror=$2 ;;
        --cloud) cloud=$(realpath "$2") ;;
      esac
      shift
      ;;
    --keep) keep=yes ;;
    -h | --help)
      sed -n '2,/^set -eu/s/^# \{0,1\}//p' "$0"
      exit 0
      ;;
    *) die "unknown option $1 (see --help)" ;;
  esac
  shift
done

skip() {
  say "SKIPPED: $*"
  exit 0
}
[ "$(id -u)" -eq 0 ] || skip "a chroot needs root"
if [ -z "$mirror" ]; then
  mirror=$(sed -n -e 's/^deb \(\[[^]]*\] \)\{0,1\}\(http[^ ]*debian\/\{0,1\}\) .*/\2/p' -e 's/^URIs: *\(http[^ ]*debian\/\{0,1\}\)$/\1/p' \
    /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null | grep -v security | head -n 1)
fi
[ -n "$mirror" ] || skip "no Debian archive in apt's sources: name one with --mirror"

# --- the MeshLab installed here: what the others are compared with -------------------------------------------------------
# shellcheck disable=SC2086  # lists of words
require_packages $host_packages $test_packages debootstrap
configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=ON
compile "$build" scripting_driver filter_shrinkwrap_recon
place=$build/newer_meshlab
mkdir -p "$place"
QT_QPA_PLATFORM=offscreen "$build/tests/meshlabserver/scripting_driver" "$build/libfilter_shrinkwrap_recon.so" reconstruct \
  "$cloud" "$place/here.dump" >"$place/here.log" || die "the plugin fails on the MeshLab installed here: $place/here.log"

# --- one suite -----------------------------------------------------------------------------------------------------------
chroot_packages="g++ cmake make xz-utils meshlab qtbase5-dev libqt5opengl5-dev libeigen3-dev libtbb-dev libcgal-dev libglew-dev
  libgtest-dev python3 xvfb xauth openbox xdotool imagemagick libgl1-mesa-dri fonts-dejavu-core ca-certificates"

inside() {
  chroot "$place/$suite" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    "$@"
}
leave() {
  umount "$place/$suite/proc" 2>/dev/null || :
  [ -n "$keep" ] || rm -rf --one-file-system "${place:?}/$suite"
}
suite=''
trap '[ -z "$suite" ] || leave' EXIT
trap 'exit 130' HUP INT TERM

make_chroot() {
  # A kept archive may be older than its own expiry date says it should be.
  date_check='Acquire::Check-Valid-Until "false";'
  if [ ! -f "$place/$suite/complete" ]; then
    umount "$place/$suite/proc" 2>/dev/null || :
    rm -rf --one-file-system "${place:?}/$suite"
    debootstrap --variant=minbase "$suite" "$place/$suite" "$mirror" >"$place/$suite.bootstrap.log" 2>&1 ||
      skip "$suite cannot be fetched from $mirror ($place/$suite.bootstrap.log)"
    echo "$date_check" >"$place/$suite/etc/apt/apt.conf.d/99valid"
    # shellcheck disable=SC2086  # a list of words
    { inside apt-get -q update && inside apt-get -q -y --no-install-recommends install $chroot_packages; } \
      >"$place/$suite.packages.log" 2>&1 || { tail -n 20 "$place/$suite.packages.log" >&2; die "$suite: packages"; }
    touch "$place/$suite/complete"
  fi
  mountpoint -q "$place/$suite/proc" || mount -t proc proc "$place/$suite/proc"
}

try_suite() {
  say "--- $suite"
  make_chroot
  version=$(inside dpkg-query -W -f='${Version}' meshlab)
  say "MeshLab $version"
  rm -rf "${place:?}/$suite/source"
  mkdir "$place/$suite/source"
  (cd "$root" && tar -c --exclude=./build* --exclude=./.git .) | tar -x -C "$place/$suite/source"
  cp "$cloud" "$place/$suite/cloud.ply"
  mkdir -p "$place/$suite/eigen/include" "$place/$suite/eigen/share/eigen3"
  cp -r /usr/include/eigen3 "$place/$suite/eigen/include/"
  cp -r /usr/share/eigen3/cmake "$place/$suite/eigen/share/eigen3/"

  inside sh /source/tests/newer_meshlab/inside.sh >"$place/$suite.log" 2>&1 || {
    tail -n 40 "$place/$suite.log" >&2
    die "$suite: failed (all of its output: $place/$suite.log)"
  }
  cat "$place/$suite.log"
  for picture in "$place/$suite"/pictures/*.png; do
    [ ! -f "$picture" ] || cp "$picture" "$place/$suite.$(basename "$picture")"
  done
  cp "$place/$suite/functions.md" "$place/$suite.functions.md"
  cmp "$place/here.dump" "$place/$suite/mesh.dump" || die "$suite: another mesh than that of the MeshLab installed here"
  echo "$suite: MeshLab $version makes the same mesh, byte for byte"
  # The documented table of functions is that of the newest interface.
  sed '1,/^<!-- generated/d' "$root/docs/pymeshlab.md" | cmp -s - "$place/$suite/functions.md" ||
    die "$suite: docs/pymeshlab.md is not what the plugin says; see $place/$suite.functions.md"
}

for suite in $suites; do
  try_suite
  leave
  echo "$suite: passed; pictures: $place/$suite.*.png"
done
suite=''
