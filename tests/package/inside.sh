#!/bin/sh
# inside.sh NAME PLUGIN: the part of run.sh that sees a view of the system of its own. Beside it are package.deb,
# cloud.ply and script.mlx.
set -eu
name=$1 plugin=$2
cd "$(dirname "$0")"

fail() {
  echo "inside.sh: $*" >&2
  [ ! -f log ] || tail -n 20 log >&2
  exit 1
}
passed() { echo "passed: $*"; }
reconstruct() {
  rm -f mesh.ply log
  xvfb-run -a meshlabserver -i cloud.ply -o mesh.ply -s script.mlx >log 2>&1
}

[ -x /usr/bin/meshlabserver ] || fail "no MeshLab in this view of the system: is /usr a file system of its own?"
# A plugin that was installed here before, by hand or as a package.
if dpkg -s "$name" >/dev/null 2>&1; then dpkg --purge "$name" >log 2>&1 || fail "the package that was there stays"; fi
rm -f "$plugin" log

if reconstruct; then fail "the filter is there before the package is"; fi

# The package is for one release of MeshLab.
sed -i.kept '/^Package: meshlab$/,/^$/s/^Version: .*/Version: 2099.01-1/' /var/lib/dpkg/status
if dpkg --install package.deb >log 2>&1; then fail "dpkg takes it beside another MeshLab than it was built for"; fi
mv /var/lib/dpkg/status.kept /var/lib/dpkg/status
passed "dpkg refuses it beside another MeshLab"

dpkg --install package.deb >log 2>&1 || fail "dpkg --install"
[ -f "$plugin" ] || fail "the package is installed, but there is no $plugin"
reconstruct || fail "meshlabserver fails with the package installed"
grep -q 'Shrink Wrap succeeded' log || fail "meshlabserver does not say that the filter succeeded"
[ "$(sed -n 's/^element vertex //p' mesh.ply | head -n 1)" = "$(sed -n 's/^element vertex //p' cloud.ply | head -n 1)" ] ||
  fail "not as many vertices as samples"
passed "dpkg --install, and a run of the system's meshlabserver"

dpkg --purge "$name" >log 2>&1 || fail "dpkg --purge"
[ ! -e "$plugin" ] || fail "the plugin is still there after dpkg --purge"
if reconstruct; then fail "the filter is still there after dpkg --purge"; fi
grep -q 'Shrink Wrap.*not found' log || fail "meshlabserver fails for another reason than that the filter is gone"
passed "dpkg --purge, and the filter is gone"
