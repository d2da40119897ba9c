#!/bin/sh
# click.sh MESHLAB CLOUD PICTURES: what a person does, on the display that is there: opens a cloud in MeshLab, types the
# filter's name into the search box, applies it with its defaults. Leaves pictures of the dialog and of the result, and
# fails unless MeshLab's log says that the filter succeeded.
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

# Stock plugins whose libraries are not there are told in a window of its own.
is_open() {
  if other=$(xdotool search --onlyvisible --name 'Error while loading' 2>/dev/null); then
    xdotool windowactivate --sync "$other" key Return
  fi
  xdotool search --onlyvisible --name 'MeshLab [0-9]'
}
wait_for 90 is_open
sleep 8
window=$(xdotool search --onlyvisible --name 'MeshLab [0-9]' | tail -n 1)
xdotool windowactivate --sync "$window" windowsize "$window" 1400 930 windowmove "$window" 0 0
sleep 3
import -window root "$pictures/opened.png"
key ctrl+f
xdotool type --delay 60 "Surface Reconstruction: Shrink"
sleep 3
import -window root "$pictures/search.png"
xdotool mousemove 1055 112 click 1
wait_for 20 xdotool search --onlyvisible --name '^Surface Reconstruction: Shrink Wrap'
sleep 3
import -window root "$pictures/dialog.png"

# Apply is at three quarters of the dialog's width, 23 pixels above its lower edge.
eval "$(xdotool search --onlyvisible --name '^Surface Reconstruction: Shrink Wrap' getwindowgeometry --shell)"
xdotool mousemove $((X + WIDTH * 3 / 4)) $((Y + HEIGHT - 22)) click 1
wait_for 120 grep -q 'Shrink Wrap [sf]' "$home/host.log"
sed -n 's/^LOG: [0-9]* \(Shrink Wrap [sf]\)/\1/p' "$home/host.log"
grep -q 'Shrink Wrap succeeded' "$home/host.log"
xdotool mousemove $((X + WIDTH / 4)) $((Y + HEIGHT - 22)) click 1
sleep 3
import -window root "$pictures/result.png"
