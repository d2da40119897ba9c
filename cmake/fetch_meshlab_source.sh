#!/bin/sh
# Fetches the headers of the installed MeshLab, which its package does not ship, from its source package.
#
#   sh fetch_meshlab_source.sh FOLDER
#
# Makes FOLDER with src/common, vcglib/vcg, vcglib/wrap and ML_VERSION of exactly the installed version. Needs no
# root: apt runs on private folders, with the archives that this machine's own sources name, and checks signatures
# and checksums as usual. Does nothing if FOLDER is there, of that version.
set -eu

target=${1:?usage: fetch_meshlab_source.sh FOLDER}

fail() {
  echo "fetch_meshlab_source: $*" >&2
  echo "fetch_meshlab_source: to do without, unpack the sources of your MeshLab and pass" \
    "-DSHRINKWRAP_MESHLAB_SOURCE_DIR=<folder> to cmake" >&2
  exit 1
}

# shellcheck disable=SC2016  # the braces are dpkg-query's
version=$(dpkg-query -W -f='${source:Version}' meshlab 2>/dev/null) || version=''
if [ -f "$target/complete" ]; then
  case $version in '' | "$(cat "$target/complete")") exit 0 ;; esac
fi
[ -n "$version" ] || fail "MeshLab is not installed (apt: meshlab)"

mkdir -p "$(dirname "$target")"
work=$(mktemp -d -p "$(dirname "$target")")
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
mkdir -p "$work/lists/partial" "$work/cache/archives/partial" "$work/parts" "$work/source"

# The machine's own sources, as sources of source packages, options such as signed-by included.
[ ! -f /etc/apt/sources.list ] || sed -n 's/^[[:space:]]*deb[[:space:]]/deb-src /p' /etc/apt/sources.list >"$work/parts/of-sources.list.list"
for entry in /etc/apt/sources.list.d/*.list; do
  [ ! -f "$entry" ] || sed -n 's/^[[:space:]]*deb[[:space:]]/deb-src /p' "$entry" >"$work/parts/$(basename "$entry")"
done
for entry in /etc/apt/sources.list.d/*.sources; do
  [ ! -f "$entry" ] || sed 's/^[Tt]ypes:.*/Types: deb-src/' "$entry" >"$work/parts/$(basename "$entry")"
done

private_apt() {
  apt-get -q -o "Dir::State::lists=$work/lists" -o "Dir::Cache=$work/cache" -o Dir::Etc::sourcelist=/dev/null \
    -o "Dir::Etc::sourceparts=$work/parts" -o APT::Sandbox::User= -o Acquire::Retries=3 "$@"
}

# An archive without source packages, of no interest here, fails the update of all, and a mirror in the middle of an
# update may lack a file that is not needed: what counts is whether the sources came.
private_apt update >"$work/log" 2>&1 || :
(cd "$work/source" && private_apt --download-only --only-source source "meshlab=$version") >>"$work/log" 2>&1 || :
set -- "$work"/source/*.orig.tar.*
if [ ! -f "$1" ]; then
  tail -n 20 "$work/log" >&2
  fail "the sources of meshlab $version could not be fetched"
fi

mkdir "$work/kept"
for archive in "$work"/source/*.orig*.tar.*; do
  case $archive in *.asc) continue ;; esac
  # A component archive (orig-vcglib) holds the content of that folder; the main archive has it, or not.
  component=$(basename "$archive" | sed -n 's/.*\.orig-\(.*\)\.tar\..*/\1/p')
  folder=$work/kept
  [ -z "$component" ] || folder=$work/kept/src/$component
  mkdir -p "$folder"
  tar -xf "$archive" -C "$folder" --strip-components=1
done
kept=$work/kept
if [ -d "$kept/src/vcglib/vcg" ]; then vcglib=src/vcglib; else vcglib=vcglib; fi
for part in src/common "$vcglib/vcg" "$vcglib/wrap"; do
  [ -d "$kept/$part" ] || fail "the source package of meshlab $version has no $part"
done

mkdir -p "$work/out/src/external" "$work/out/vcglib"
mv "$kept/src/common" "$work/out/src/common"
for library in "$kept"/src/external/easyexif*/; do # which src/common needs to be compiled, by tests/newer_meshlab
  [ ! -f "$library/exif.cpp" ] || mv "$library" "$work/out/src/external/easyexif"
done
mv "$kept/$vcglib/vcg" "$kept/$vcglib/wrap" "$work/out/vcglib/"
for file in ML_VERSION LICENSE.txt; do
  [ ! -f "$kept/$file" ] || mv "$kept/$file" "$work/out/"
done
echo "$version" >"$work/out/complete"
rm -rf "$target"
mv "$work/out" "$target"
