#!/bin/sh
# Runs the plugin on newer MeshLabs than the one installed, each in a chroot of its own. On this system it installs what is
# missing through apt (what the plugin and its tests are built with, wget and debootstrap); the MeshLab installed here stays.
#
#   sh tests/newer_meshlab/run.sh [--suites "unstable trixie"] [--mirror URL] [--cloud FILE] [--keep]
#
# --suites   Debian suites whose MeshLab is tried (default: unstable, MeshLab 2025.07, and trixie, MeshLab 2022.02)
# --mirror   archive to take them from (default: the one that this machine's own apt sources name)
# --cloud    the cloud that is reconstructed (default: the cactus of the sample clouds)
# --keep     leave the chroots where they are (<build>/newer_meshlab/<suite>): the next run is quick
#
# For each suite: makes a chroot with debootstrap; builds the plugin in it against that release's own source package, and
# runs its test; does with it what PyMeshLab does, and compares the mesh byte for byte with that of the MeshLab installed
# here; does it again with double coordinates, on that release's common library built with them; times its own
# reconstructions of the cloud; then starts the real MeshLab under Xvfb, applies the filter from its menu, exports the new
# layer and compares that too. Pictures are kept.
#
# Leaves with 0 if every suite passed; with 0 and the word SKIPPED where root or the archive is missing, since nothing was
# found wrong; with 1 if anything failed, after the other suites have been tried.
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
[ -f "$cloud" ] || die "there is no $cloud"

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
mirror=${mirror%/}

# An archive that does not answer is the network's fault; one that answers otherwise is no archive.
command -v wget >/dev/null || require_packages wget
answer=0
wget -q --tries=2 --timeout=30 -O /dev/null "$mirror/dists/stable/Release" || answer=$?
case $answer in
  0) ;;
  4) skip "the archive $mirror cannot be reached" ;;
  *) die "$mirror is no Debian archive (wget left with $answer)" ;;
esac

# --- the MeshLab installed here: what the others are compared with -------------------------------------------------------
# shellcheck disable=SC2086  # lists of words
require_packages $host_packages $test_packages debootstrap
configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=ON
compile "$build" scripting_driver filter_shrinkwrap_recon
place=$build/newer_meshlab
mkdir -p "$place"
place=$(cd "$place" && pwd -P)
QT_QPA_PLATFORM=offscreen "$build/tests/meshlabserver/scripting_driver" "$build/libfilter_shrinkwrap_recon.so" reconstruct \
  "$cloud" "$place/here.dump" >"$place/here.log" 2>&1 || die "the plugin fails on the MeshLab installed here: $place/here.log"

# --- one suite -----------------------------------------------------------------------------------------------------------
chroot_packages="g++ ccache cmake make xz-utils qtbase5-dev libqt5opengl5-dev libeigen3-dev libtbb-dev libcgal-dev libglew-dev
  libgtest-dev python3 python3-gi at-spi2-core dbus xvfb xauth openbox xdotool imagemagick libgl1-mesa-dri
  fonts-dejavu-core ca-certificates"

inside() {
  chroot "$place/$suite" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    "$@"
}

# Ends what still runs in the chroot, which would keep its folders busy, and takes it away.
leave() {
  for process in /proc/[0-9]*; do
    case $(readlink "$process/root" 2>/dev/null || :) in
      "$place/$suite") kill -9 "${process#/proc/}" 2>/dev/null || : ;;
    esac
  done
  if mountpoint -q "$place/$suite/proc"; then
    umount "$place/$suite/proc" || umount -l "$place/$suite/proc"
  fi
  [ -n "$keep" ] || rm -rf --one-file-system "${place:?}/$suite"
}

make_chroot() {
  if [ ! -f "$place/$suite/complete" ]; then
    leave
    rm -rf --one-file-system "${place:?}/$suite"
    quietly "$place/$suite.bootstrap.log" debootstrap --variant=minbase "$suite" "$place/$suite" "$mirror"
    # A kept copy of an archive may be older than its own expiry date says it should be.
    echo 'Acquire::Check-Valid-Until "false";' >"$place/$suite/etc/apt/apt.conf.d/99valid"
    quietly "$place/$suite.update.log" inside apt-get -q update
    # shellcheck disable=SC2086  # a list of words
    quietly "$place/$suite.packages.log" inside apt-get -q -y --no-install-recommends install $chroot_packages
    # With what it recommends: libraries without which some of its own plugins do not load, and it says so in a window.
    quietly "$place/$suite.meshlab.log" inside apt-get -q -y install meshlab
    touch "$place/$suite/complete"
  fi
  mountpoint -q "$place/$suite/proc" || mount -t proc proc "$place/$suite/proc"
}

try_suite() {
  make_chroot
  # shellcheck disable=SC2016  # the braces are dpkg-query's
  version=$(inside dpkg-query -W -f='${Version}' meshlab)
  say "$suite: MeshLab $version"
  rm -rf "${place:?}/$suite/source" "$place/$suite/pictures"
  mkdir "$place/$suite/source"
  (cd "$root" && tar -c --exclude=./build* --exclude="./${build#"$root"/}" --exclude=./.git .) | tar -x -C "$place/$suite/source"
  cp "$cloud" "$place/$suite/cloud.ply"
  mkdir -p "$place/$suite/eigen/include" "$place/$suite/eigen/share/eigen3"
  cp -r /usr/include/eigen3 "$place/$suite/eigen/include/"
  cp -r /usr/share/eigen3/cmake "$place/$suite/eigen/share/eigen3/"

  result=0
  inside sh /source/tests/newer_meshlab/inside.sh >"$place/$suite.log" 2>&1 || result=$?
  for picture in "$place/$suite"/pictures/*.png; do
    [ ! -f "$picture" ] || cp "$picture" "$place/$suite.$(basename "$picture")"
  done
  [ $result -eq 0 ] || {
    tail -n 40 "$place/$suite.log" >&2
    die "$suite: failed (all of its output: $place/$suite.log)"
  }
  cat "$place/$suite.log"
  cp "$place/$suite/functions.md" "$place/$suite.functions.md"
  cp "$place/$suite/builtins.md" "$place/$suite.builtins.md"
  cmp "$place/here.dump" "$place/$suite/mesh.dump" || die "$suite: another mesh than that of the MeshLab installed here"
  echo "$suite: MeshLab $version makes the same mesh as the one installed here, byte for byte"
  sed '1,/^<!-- generated/d' "$root/docs/pymeshlab.md" | cmp - "$place/$suite/functions.md" ||
    die "$suite: docs/pymeshlab.md is not what the plugin says; see $place/$suite.functions.md"
  echo "$suite: its functions are those of docs/pymeshlab.md"
}

suite=''
trap '[ -z "$suite" ] || leave' EXIT
trap 'exit 130' INT
trap 'exit 143' HUP TERM

failed=''
for suite in $suites; do
  say "--- $suite"
  rm -f "$place/$suite".*
  set +e # a shell of its own ends at the first failure, which it would not as a condition
  (
    set -e
    try_suite
  )
  result=$?
  set -e
  leave
  if [ $result -eq 0 ]; then
    echo "$suite: passed; pictures: $place/$suite.*.png"
  else
    failed="$failed $suite"
  fi
done
suite=''
[ -z "$failed" ] || die "failed:$failed"
