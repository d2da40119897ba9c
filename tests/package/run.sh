#!/bin/sh
# Installs the plugin in every documented way, runs MeshLab with it, and takes it away again.
#
#   sh tests/package/run.sh
#
# `cmake --install` into a prefix of its own, and with DESTDIR; then `cpack`, lintian (if it is there), and the package
# itself: dpkg -i, the system's meshlabserver, dpkg --purge, in a view of this system that keeps its changes apart
# (overlay file system, mount and network namespaces of their own), so that the package changes nothing here. That last
# part needs root and a kernel that grants it; where it cannot be, it is SKIPPED, in this word, and the rest counts.
#
# What is missing to build is installed through apt (with sudo when not root), and stays.
#
# Run by hand: it compiles all that the build folder builds (after tests/run.sh: nothing), then takes half a minute.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/cmake/setup.sh"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' HUP INT TERM

# Without a maintainer a package is for this machine alone, and lintian would say so.
export DEBFULLNAME="Test of the package" DEBEMAIL=package-test@example.org

# shellcheck disable=SC2086  # a list of words
require_packages $host_packages $package_tools
configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -U CMAKE_INSTALL_PREFIX # the default, whatever the folder was configured with
compile "$build"

plugin_path=lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH)/meshlab/plugins/libfilter_shrinkwrap_recon.so
cloud=$root/sample_clouds/cactus_3280.ply
script=$root/sample_clouds/reconstruct.mlx

passed() { echo "passed: $*"; }

# --- cmake --install -------------------------------------------------------------------------------------------------
DESTDIR=$work/destdir cmake --install "$build" >"$work/log"
[ -f "$work/destdir/usr/$plugin_path" ] || die "DESTDIR: no plugin among MeshLab's own; see what was installed: $(cat "$work/log")"
passed "cmake --install with DESTDIR"

# A MeshLab of which this prefix is the home.
prefix=$work/prefix
cmake -DSTAGE="$prefix" -DPREFIX=/usr -DLIBRARY_DIR=/usr/"$(dirname "$(dirname "$plugin_path")")" -DPLUGIN= -P "$root/cmake/StageMeshLab.cmake"
rm -f "$prefix/$plugin_path" # if the package is installed here
cmake --install "$build" --prefix "$prefix" >"$work/log"
if [ ! -f "$prefix/$plugin_path" ] || [ -L "$prefix/$plugin_path" ]; then die "--prefix: no plugin in $plugin_path"; fi
xvfb-run -a "$prefix/bin/meshlabserver" -i "$cloud" -o "$work/prefix.ply" -s "$script" >"$work/log" 2>&1 ||
  { tail -n 20 "$work/log" >&2; die "meshlabserver fails with the plugin installed into a prefix"; }
[ -s "$work/prefix.ply" ] || die "meshlabserver wrote no mesh with the plugin installed into a prefix"
passed "cmake --install --prefix, and a run"

xargs -d '\n' rm -- <"$build/install_manifest.txt"
[ ! -e "$prefix/$plugin_path" ] || die "the plugin is still there after its removal by the manifest"
passed "removal by install_manifest.txt"

# --- the package -----------------------------------------------------------------------------------------------------
(cd "$build" && cpack -B "$work/package") >"$work/log" 2>&1 || { cat "$work/log" >&2; die "cpack fails"; }
set -- "$work"/package/*.deb
if [ $# -ne 1 ] || [ ! -f "$1" ]; then die "not one package, but: $*"; fi
package=$1
name=$(dpkg-deb -f "$package" Package)
passed "cpack: $(basename "$package")"

if command -v lintian >/dev/null 2>&1; then
  lintian --allow-root --fail-on error,warning "$package" >&2 || die "lintian complains"
  passed "lintian"
else
  echo "SKIPPED: lintian is not installed"
fi

skip() {
  echo "SKIPPED: $*; the package was not installed"
  exit 0
}
[ "$(id -u)" -eq 0 ] || skip "a view of the system that keeps changes apart needs root"
mkdir "$work/view"
# What follows sees a system of its own from the first mount on, and ends with all that it started.
# shellcheck disable=SC2016  # for the inner shell
unshare --mount --net --pid --fork --kill-child sh -c '
  mount -t tmpfs none "$1" && mkdir "$1/changes" "$1/work" "$1/system" &&
    mount -t overlay overlay -o "lowerdir=/,upperdir=$1/changes,workdir=$1/work" "$1/system"' sh "$work/view" 2>"$work/log" ||
  skip "this kernel refuses an overlay of the system ($(tail -n 1 "$work/log"))"

# shellcheck disable=SC2016
unshare --mount --net --pid --fork --kill-child sh -c '
  set -eu
  mount -t tmpfs none "$1"
  mkdir "$1/changes" "$1/work" "$1/system"
  mount -t overlay overlay -o "lowerdir=/,upperdir=$1/changes,workdir=$1/work" "$1/system"
  mount -t proc proc "$1/system/proc"
  mount --rbind /dev "$1/system/dev"
  mount -t tmpfs none "$1/system/tmp" # the sockets of the X server
  mount -t tmpfs none "$1/system/mnt"
  cp "$2" "$1/system/mnt/package.deb"
  cp "$3" "$1/system/mnt/cloud.ply"
  cp "$4" "$1/system/mnt/script.mlx"
  cp "$5" "$1/system/mnt/inside.sh"
  chroot "$1/system" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/mnt XDG_CACHE_HOME=/mnt LC_ALL=C.UTF-8 sh /mnt/inside.sh "$6" "$7"
  # What is left of it all: changed or deleted files, but those in which dpkg keeps its books.
  cd "$1/changes"
  find . ! -type d ! -path "./var/lib/dpkg/*" ! -path "./var/log/*" ! -path "./var/cache/*" >"$8"
  ' sh "$work/view" "$package" "$cloud" "$script" "$root/tests/package/inside.sh" "$name" "/usr/$plugin_path" "$work/left" ||
  die "the package does not work"
[ ! -s "$work/left" ] || die "left behind by the package: $(cat "$work/left")"
passed "nothing is left behind"
