#!/bin/sh
# The part of run.sh that runs in the chroot: /source and /cloud.ply are there, MeshLab is installed. Fails at the first
# thing that does not hold. Writes /functions.md, /mesh.dump, /builtins.md and /pictures.
set -eu

root=/source
. "$root/cmake/setup.sh"
export QT_QPA_PLATFORM=offscreen XDG_RUNTIME_DIR=/tmp
# Most of the plugin is the same for both scalars.
export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_DIR=/ccache
plugins=$(echo /usr/lib/*/meshlab/plugins)
# Releases of Eigen sum in different orders: with one and the same, the meshes must be the same.
eigen=-DEigen3_DIR=/eigen/share/eigen3/cmake

# Of the run before, in a chroot that was kept: to overwrite a mesh, the window would ask first.
rm -f /functions.md /builtins.md /mesh.dump /mesh_double.dump /window.ply /window.dump

echo "--- the plugin, for this release's own sources"
configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=ON "$eigen"
compile "$build" filter_shrinkwrap_recon scripting_driver plugin_test mesh_checker
grep -h '^-- MeshLab' "$build/configure.log"
plugin=$build/libfilter_shrinkwrap_recon.so
driver=$build/tests/meshlabserver/scripting_driver

echo "--- the plugin as the host sees it"
"$build/tests/meshlabserver/plugin_test" "$plugin" >/plugin_test.log 2>&1 || {
  cat /plugin_test.log
  exit 1
}
tail -n 1 /plugin_test.log

echo "--- as PyMeshLab uses it"
"$driver" "$plugin" functions >/functions.md
echo "$(grep -c '^## ' /functions.md) functions"
"$driver" "$plugin" reconstruct /cloud.ply /mesh.dump

echo "--- with double coordinates, as PyMeshLab's own host has"
quietly /build_host.log cmake -S "$root/tests/newer_meshlab/double_host" -B /source/build-host "$eigen" \
  -DMESHLAB_SOURCE_DIR="$build/meshlab-source"
compile /source/build-host meshlab-common
configure /source/build-double -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=ON "$eigen" \
  -DSHRINKWRAP_MESHLAB_SCALAR=double -DSHRINKWRAP_MESHLAB_SOURCE_DIR="$build/meshlab-source" \
  -DSHRINKWRAP_MESHLAB_COMMON=/source/build-host/libmeshlab-common.so
compile /source/build-double filter_shrinkwrap_recon scripting_driver
/source/build-double/tests/meshlabserver/scripting_driver /source/build-double/libfilter_shrinkwrap_recon.so reconstruct \
  /cloud.ply /mesh_double.dump

echo "--- this release's own reconstructions of the same cloud, with their defaults"
LD_LIBRARY_PATH=${plugins%/plugins} "$driver" "$plugin" builtins /cloud.ply "$plugins" >/builtins.md 2>/builtins.log || {
  tail -n 20 /builtins.log
  exit 1
}
cat /builtins.md

echo "--- the window"
mkdir -p /pictures
# Displays of the system around the chroot may have the usual numbers; a display without clients must not start anew,
# which would end what is about to become one.
env -u QT_QPA_PLATFORM -u XDG_RUNTIME_DIR \
  xvfb-run -n $((1000 + $$ % 5000)) -s "-screen 0 1400x950x24 +extension GLX -noreset" dbus-run-session -- \
  python3 /source/tests/newer_meshlab/window.py "$build/stage/bin/meshlab" /cloud.ply /window.ply /pictures
"$build/tests/meshlabserver/mesh_checker" /window.ply /cloud.ply >/window.txt
for part in 'closed 1' 'manifold 1' 'outward 1' 'complete 1'; do
  grep -qx "$part" /window.txt || {
    cat /window.txt
    die "the mesh that the window exported: not \"$part\""
  }
done
"$driver" "$plugin" dump /window.ply /window.dump
cmp /mesh.dump /window.dump
echo "the mesh that the window exported is the driver's, byte for byte"
