#!/bin/sh
# Does what a person does in the real MeshLab, and takes pictures of it.
#
#   sh docs/screenshots.sh [CLOUD...]
#
# Under Xvfb, with a screen of a laptop (1280 x 900): opens each cloud (default: three of the sample clouds), finds every
# filter of ours with the search box and applies it with its defaults, one after the other. Writes to
# <build>/screenshots/NAME: the menu, each dialog, what each filter leaves in the window, and MeshLab's log. Leaves with 1
# if a filter fails, or a dialog does not fit the screen.
#
# With the default clouds it also renews the pictures of the README (docs/pictures/meshlab_*.png): look at them.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/cmake/setup.sh"

width=1280 height=900
readme_cloud=golf_club_head_12321

# --- outside: builds, and starts itself once more for each cloud, on a display of its own ---------------------------------
if [ "${1:-}" != --inside ]; then
  # shellcheck disable=SC2086  # a list of words
  require_packages $host_packages openbox xdotool imagemagick libgl1-mesa-dri fonts-dejavu-core
  configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON
  compile "$build" filter_shrinkwrap_recon
  is_default=''
  if [ $# -eq 0 ]; then
    is_default=yes
    set -- "$root/sample_clouds/$readme_cloud.ply" "$root/sample_clouds/mechanical_part_7612.ply" "$root/sample_clouds/cactus_3280.ply"
  fi
  status=0
  for cloud in "$@"; do
    name=$(basename "$cloud")
    pictures=$build/screenshots/${name%.*}
    rm -rf "$pictures"
    mkdir -p "$pictures"
    echo "--- $name"
    xvfb-run -a -s "-screen 0 ${width}x${height}x24 +extension GLX" sh "$root/docs/screenshots.sh" --inside \
      "$(realpath "$cloud")" "$pictures" || status=1
  done
  if [ -n "$is_default" ] && [ $status -eq 0 ]; then
    for picture in menu dialog result; do
      case $picture in
        menu) taken=menu ;;
        dialog) taken=1_dialog ;;
        result) taken=1_mesh ;;
      esac
      part=${width}x$height  # the log beside the first two names folders of this machine
      [ "$taken" = 1_mesh ] || part=860x868
      convert "$build/screenshots/$readme_cloud/$taken.png" -crop "$part+0+0" +repage +dither -colors 240 -strip -define png:compression-level=9 \
        "PNG8:$root/docs/pictures/meshlab_$picture.png"
    done
  fi
  echo "pictures: $build/screenshots"
  exit $status
fi

# --- inside: one cloud, on the display that is there ----------------------------------------------------------------------
cloud=$2 pictures=$3
home=$(mktemp -d)
export HOME="$home" LIBGL_ALWAYS_SOFTWARE=1 XDG_RUNTIME_DIR="$home"
chmod 700 "$home"
log=$pictures/log.txt

openbox >/dev/null 2>&1 &
windows=$!
"$build/stage/bin/meshlab" "$cloud" >"$log" 2>&1 &
host=$!
# shellcheck disable=SC2317  # for the trap
finish() {
  kill "$host" "$windows" 2>/dev/null || :
  rm -rf "$home"
}
trap finish EXIT
trap 'exit 130' HUP INT TERM

give_up() {
  import -window root "$pictures/stuck.png" || :
  die "$* (see $pictures/stuck.png, $log)"
}
wait_for() { # seconds, command ...
  left=$(($1 * 4))
  shift
  while [ "$left" -gt 0 ]; do
    if "$@" >/dev/null 2>&1; then return 0; fi
    kill -0 "$host" 2>/dev/null || die "MeshLab ended: $(tail -n 3 "$log")"
    sleep 0.25
    left=$((left - 1))
  done
  give_up "waited in vain for: $*"
}
take() { # name [part of the screen]: a picture, once the window has come to rest
  import -window root ${2:+-crop "$2"} "$pictures/$1.png"
  for _ in 1 2 3 4 5 6 7 8 9 10; do
    sleep 0.5
    mv "$pictures/$1.png" "$home/before.png"
    import -window root ${2:+-crop "$2"} "$pictures/$1.png"
    if [ "$(compare -metric AE "$home/before.png" "$pictures/$1.png" null: 2>&1)" = 0 ]; then return 0; fi
  done
}
click() { # x, y
  xdotool mousemove "$1" "$2"
  sleep 0.2
  xdotool click 1
}
# Hides the first layer for a picture: a click on its eye, a little to the right of the left edge of the list of layers. Where
# that is, the colour of the current layer's row tells, which is the second and is made current again afterwards.
take_without_points() {
  edge=$(convert "$pictures/1_result.png" -crop "${width}x1+0+154" -depth 8 txt:- |
    sed -n 's/^\([0-9]*\),0: .*#308CC6.*/\1/p' | head -n 1)
  [ -n "$edge" ] || give_up "no second layer in the list of layers"
  click $((edge + 21)) 133
  click $((edge + 150)) 164
  take 1_mesh
  xdotool mousemove 380 460 mousedown 1 mousemove --sync 420 400 mousemove --sync 480 320 mousemove --sync 520 260 mouseup 1
  take 1_turned
  click $((edge + 21)) 133
  click $((edge + 150)) 164
}
window_named() { xdotool search --onlyvisible --name "$1" 2>/dev/null; } # a window may go while it is looked at
verdicts() { grep -c '^LOG: [0-9]* Shrink Wrap [sf]' "$log" || :; }
# shellcheck disable=SC2317  # for wait_for
has_verdicts() { [ "$(verdicts)" -ge "$1" ]; }

wait_for 120 grep -q 'All files opened' "$log"
wait_for 30 window_named 'MeshLab 20'
window=$(window_named 'MeshLab 20' | tail -n 1)
xdotool windowactivate --sync "$window" windowmove "$window" 0 0 windowsize "$window" $width $((height - 20))
take opened

# The menu Filters, and in it the fourteenth entry, Point Set.
click 121 29
xdotool key --delay 60 Down Down Down Down Down Down Down Down Down Down Down Down Down Down Right
xdotool key --delay 60 Up # to the last: Surface Reconstruction
take menu
xdotool key --delay 100 Escape Escape Escape

# Finds the filter with the search box, whose hits are still those of half its name if the machine is busy.
open_dialog() {
  for _ in 1 2 3; do
    xdotool key --clearmodifiers ctrl+f
    sleep 1
    xdotool key --clearmodifiers ctrl+a BackSpace
    xdotool type --delay 40 "$filter"
    sleep 1
    take search "480x220+$((width - 490))+106" # the hits: a cursor blinks above them
    click $((width - 300)) 118                 # the first
    for _ in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16; do
      if window_named "^$filter\$" >/dev/null; then return 0; fi
      sleep 0.5
    done
  done
  give_up "no dialog $filter"
}

status=0 number=0
while read -r filter; do
  number=$((number + 1))
  open_dialog
  take "${number}_dialog"

  eval "$(xdotool search --onlyvisible --name "^$filter\$" getwindowgeometry --shell)"
  # shellcheck disable=SC2153  # WIDTH and HEIGHT are xdotool's
  echo "$filter: dialog of $WIDTH x $HEIGHT"
  if [ $((Y + HEIGHT)) -gt $height ] || [ $((X + WIDTH)) -gt $width ]; then
    say "$filter: the dialog does not fit a screen of $width x $height"
    status=1
  fi
  before=$(verdicts)
  click $((X + WIDTH * 3 / 4)) $((Y + HEIGHT - 22)) # Apply
  wait_for 300 has_verdicts $((before + 1))
  verdict=$(sed -n 's/^LOG: [0-9]* \(Shrink Wrap [sf]\)/\1/p' "$log" | tail -n 1)
  echo "  $verdict"
  case $verdict in *failed*) status=1 ;; esac
  click $((X + WIDTH / 4)) $((Y + HEIGHT - 22)) # Close
  take "${number}_result"
  [ $number -gt 1 ] || take_without_points
done <<'FILTERS'
Surface Reconstruction: Shrink Wrap
Shrink Wrap: Initial Mesh
Shrink Wrap: Control Mesh
Shrink Wrap: Parametric Surface
Shrink Wrap: Complete Matching
Shrink Wrap: Edge Optimisation
Shrink Wrap: Matching Report
Shrink Wrap: Distance to Samples
FILTERS
exit $status
