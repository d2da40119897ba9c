#!/bin/sh
# The part of run.sh that runs in the chroot: /source and /cloud.ply are there, MeshLab is installed.
# Writes /functions.md, /mesh.dump and /pictures.
set -eu

root=/source
. "$root/cmake/setup.sh"

# Releases of Eigen sum in different orders: with one and the same, the meshes must be the same.
eigen=-DEigen3_DIR=/eigen/share/eigen3/cmake
configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=ON "$eigen"
compile "$build" filter_shrinkwrap_recon scripting_driver plugin_test

# PyMeshLab brings a MeshLab of its own, with double coordinates: Debian has none to link with, so compile only.
configure /source/build-double -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=OFF -DSHRINKWRAP_MESHLAB_SCALAR=double "$eigen" \
  -DSHRINKWRAP_MESHLAB_SOURCE_DIR="$build/meshlab-source"
make -s -C /source/build-double filter_shrinkwrap_recon/filter_shrinkwrap_recon.o
echo "compiles for double coordinates"

plugin=$build/libfilter_shrinkwrap_recon.so
driver="env QT_QPA_PLATFORM=offscreen $build/tests/meshlabserver/scripting_driver"
$driver "$plugin" functions >/functions.md
$driver "$plugin" reconstruct /cloud.ply /mesh.dump
echo "the host's own reconstructions of the same cloud:"
$driver "$plugin" builtins /cloud.ply "$(echo /usr/lib/*/meshlab/plugins)" 2>/builtins.log || echo "  (not all of them could be run)"
QT_QPA_PLATFORM=offscreen "$build/tests/meshlabserver/plugin_test" "$plugin" >/plugin_test.log 2>&1 || {
  cat /plugin_test.log
  exit 1
}
tail -n 1 /plugin_test.log

mkdir -p /pictures
xvfb-run -a -s "-screen 0 1400x950x24 +extension GLX" sh /source/tests/newer_meshlab/click.sh "$build/stage/bin/meshlab" /cloud.ply \
  /pictures
