# Set-up shared by the scripts, to be read by a POSIX shell whose `root` is the project's folder: packages, build.
# shellcheck shell=sh disable=SC2034  # what is set here is used there

build=${SHRINKWRAP_BUILD_DIR:-$root/build}
case $build in /*) ;; *) build=$PWD/$build ;; esac
host_packages="g++ cmake make qtbase5-dev libqt5opengl5-dev libglew-dev libeigen3-dev libtbb-dev libcgal-dev xz-utils meshlab xvfb xauth"
test_packages="libgtest-dev python3"
package_tools="dpkg-dev file"

say() { printf '%s\n' "$*" >&2; }
die() {
  say "${0##*/}: $*"
  exit 1
}

# Installs the packages that are missing, as root or through sudo; needs neither if none is.
require_packages() {
  missing=''
  for package in "$@"; do
    # One line for each architecture that it is there for.
    # shellcheck disable=SC2016  # the braces are dpkg-query's
    dpkg-query -W -f='${Status}\n' "$package" 2>/dev/null | grep -qx "install ok installed" ||
      missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  as_root=''
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 || die "as root, please: apt-get install --no-install-recommends$missing"
    as_root=sudo
  fi
  say "Installing:$missing"
  # shellcheck disable=SC2086  # lists of words
  {
    $as_root apt-get -q -o DPkg::Lock::Timeout=300 update >&2 &&
      $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 \
        --no-install-recommends install $missing >&2
  } || die "the packages could not be installed:$missing"
}

# The interpreter that has a module, if any has: the first in the path need not be that of the packages.
python_with() {
  for python in python3 /usr/bin/python3; do
    if "$python" -c "import $1" 2>/dev/null; then
      echo "$python"
      return
    fi
  done
  echo python3
}

# Scripts that run at the same time take turns at a build folder.
wait_for_others() { # FOLDER
  if ! mkdir -p "$1" 2>/dev/null || [ ! -w "$1" ]; then
    die "$1 cannot be written to: name another folder to build in, SHRINKWRAP_BUILD_DIR=<folder> in the environment"
  fi
  flock -n "$1/lock" true || {
    say "Waiting for what another script builds in $1"
    flock "$1/lock" true
  }
}

# configure FOLDER [cmake options]: quick when it was done before. More than a word of it only if it fails.
configure() {
  folder=$1
  shift
  wait_for_others "$folder"
  [ -f "$folder/CMakeCache.txt" ] ||
    say "Building in $folder: some minutes the first time (compile.log there tells how far it is)"
  in_turn "$folder" configure.log cmake -S "$root" -B "$folder" "$@"
}

# compile FOLDER [targets]
compile() {
  folder=$1
  shift
  in_turn "$folder" compile.log cmake --build "$folder" --parallel "$(nproc)" ${1:+--target} "$@"
}

# in_turn FOLDER LOG program...: quietly, while no other script builds there.
in_turn() {
  lock=$1/lock log=$1/$2
  shift 2
  # shellcheck disable=SC2016  # the parameters are those of the inner shell
  flock "$lock" sh -c 'log=$1 && shift && exec "$@" >"$log" 2>&1' sh "$log" "$@" || failed "$log" "$@"
}

# quietly LOG command...: output only if it fails: its last lines, and where the rest is.
quietly() {
  log=$1
  shift
  "$@" >"$log" 2>&1 || failed "$log" "$@"
}
failed() { # LOG command...
  log=$1
  shift
  tail -n 60 "$log" >&2
  die "this failed: $* (all of its output: $log)"
}
