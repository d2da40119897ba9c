#!/bin/sh
# click.sh MESHLAB CLOUD PICTURES: what a person does, on the display that is there: opens a cloud in MeshLab, types the
# filter's name into the search box, applies it with its defaults. Leaves pictures of the dialog and of the result, and
# fails unless the log of the window's project says that the filter succeeded.
set -eu
meshlab=$1 cloud=$2 pictures=$3

home=$(mktemp -d)
export HOME="$home" LIBGL_ALWAYS_SOFTWARE=1 XDG_RUNTIME_DIR="$home"
chmod 700 "$home"
finish() {
  kill "$host" "$windows" 2>/dev/null || :
  rm -rf "$home"
}
openbox >/dev/null 2>&1 &
windows=$!
"$meshlab" "$cloud" >"$home/host.log" 2>&1 &
host=$!
trap finish EXIT

wait_for() { # seconds, command ...
  seconds=$1
  shift
  while [ "$seconds" -gt 0 ]; do
    if "$@" >/dev/null 2>&1; then return 0; fi
    kill -0 "$host" 2>/dev/null || { cat "$home/host.log" >&2; echo "MeshLab ended" >&2; exit 1; }
    sleep 1
    seconds=$((seconds - 1))
  done
  import -window root "$pictures/stuck.png" || :
  echo "waited in vain for: $*" >&2
  exit 1
}
key() { xdotool key --clearmodifiers "$@"; sleep 1; }

wait_for 60 xdotool search --onlyvisible --name '^MeshLab'
sleep 5
window=$(xdotool search --onlyvisible --name '^MeshLab' | tail -n 1)
xdotool windowactivate --sync "$window" windowsize --sync "$window" 1400 930 windowmove --sync "$window" 0 0
sleep 2
key ctrl+f
xdotool type --delay 60 "Surface Reconstruction: Shrink"
sleep 2
import -window root "$pictures/search.png"
xdotool mousemove 982 118 click 1
wait_for 20 xdotool search --onlyvisible --name 'Shrink Wrap'
sleep 1
import -window root "$pictures/dialog.png"
