#!/bin/sh
# Reconstructs point clouds with MeshLab and the Shrink Wrap plugin.
#
#   sh sample_clouds/reconstruct.sh [INPUT...] [-o OUTPUT] [-j JOBS] [options]
#
# INPUT    point clouds in any format that MeshLab reads, or folders of them; none: the sample clouds
# -o       one input: the mesh to write, its ending chooses the format; several, or a folder: the folder to write to.
#          Without: NAME_shrink_wrap.ply beside each input (the sample clouds': in sample_clouds/results)
# -j       inputs to work on at the same time (1)
# --time-limit S  seconds after which an input is given up (0: none)
# --paper      the paper's own steps and constants, for clouds of genus 0
# --surface    stop at the parametric surface, for noisy clouds
# --leave-open take the faces that span openings of the scan away
# --threads N  threads for each input (0: all)
# --set NAME=VALUE  any parameter that shapes the mesh, as often as there are some to set: --set Openings=Automatic,
#              --set MaximumGenus=0, --set ExcludeOutliers=false. Choices go by their number or their name.
#              --set help lists the names, the kinds of value and the defaults. The last of several settings counts.
#
# Does all of its own set-up, quick the second time. Prints the stages and the matching report of each input, then a
# table of all and a list of those that failed, and why; leaves with 1 if any failed. A mesh is there whole or not at
# all: not half-written when the script is stopped, and not left from an earlier run when this one fails. After a stop,
# what was not yet begun keeps the mesh of an earlier run.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/cmake/setup.sh"

script=$root/sample_clouds/reconstruct.mlx
usage() { sed -n '2,/^set -eu/s/^# \{0,1\}//p' "$0"; }

work=$(mktemp -d)
stop_hosts() { # They run in process groups of their own, which no signal from the terminal reaches.
  touch "$work/stopped"
  for group in "$work"/*/group; do
    [ ! -s "$group" ] || kill -TERM -- "-$(cat "$group")" 2>/dev/null || :
  done
  wait
}
stop() {
  trap '' HUP INT TERM PIPE
  stop_hosts
  say "Stopped: ${shown:-0} of ${total:-0} were told of above; no others are to be relied on." || :
  exit 130
}
trap 'stop_hosts; rm -rf "$work"' EXIT
trap stop HUP INT TERM PIPE

# --- arguments -----------------------------------------------------------------------------------------------------
output='' jobs=1 time_limit=0
value_of() { # option, number of arguments left, value
  [ "$2" -gt 0 ] || die "$1 needs a value"
}
edit_parameter() { # name, value
  printf '/name="%s"/s/ value="[^"]*"/ value="%s"/\n' "$1" "$2" >>"$work/edits.sed"
}
is_like() { # value, extended regular expression
  case $1 in *[!-+.0-9eE]*) return 1 ;; esac
  printf '%s\n' "$1" | grep -qxE -e "$2"
}
# The parameters of the filter but KeepStages: name, kind, default; of a choice its names as well.
list_parameters() {
  sed -n -e '/name="KeepStages"/d' \
    -e 's/.*<Param type="Rich\([A-Za-z]*\)" name="\([A-Za-z]*\)" value="\([^"]*\)"\(.*\)\/>.*/\2  \1  \3 \4/' \
    -e 's/ enum_cardinality="[0-9]*"//' -e 's/ enum_val\([0-9]*\)="\([^"]*\)"/  \1: \2/gp' -e 's/ $//p' "$script"
}
# Sets one parameter. Whether a number is within its range the filter says, which names the parameter then.
set_parameter() { # NAME=VALUE
  case $1 in
    help)
      list_parameters
      exit 0
      ;;
    ?*=*) ;;
    *) die "--set needs NAME=VALUE, not '$1'" ;;
  esac
  name=${1%%=*} value=${1#*=} line=''
  case $name in
    *[!A-Za-z]*) ;;
    *) line=$(grep "<Param .* name=\"$name\"" "$script") || : ;;
  esac
  [ -n "$line" ] || die "the filter has no parameter '$name': --set help lists them"
  wanted=''
  case $line in
    *'"RichBool"'*) case $value in true | false) ;; *) wanted="true or false" ;; esac ;;
    *'"RichInt"'*) is_like "$value" '-?[0-9]{1,9}' || wanted="a whole number" ;;
    *'"RichFloat"'*) is_like "$value" '-?([0-9]+[.]?[0-9]*|[.][0-9]+)([eE][-+]?[0-9]+)?' || wanted="a number" ;;
    *'"RichEnum"'*)
      number=$(printf '%s\n' "$line" | CHOICE=$value awk -F'"' '{
        for (i = 1; i < NF; i += 2) {
          number = $i
          if (!sub(/.*enum_val/, "", number)) continue
          sub(/=$/, "", number)
          if (ENVIRON["CHOICE"] "" == number || ENVIRON["CHOICE"] "" == $(i + 1)) print number
        }
      }')
      if [ -n "$number" ]; then value=$number; else wanted="one of its choices, by number or name"; fi
      ;;
    *) die "the parameter $name cannot be set" ;;
  esac
  [ -z "$wanted" ] || die "$name needs $wanted, not '$value': --set help lists the parameters"
  [ "$name=$value" != KeepStages=true ] || die "KeepStages is for MeshLab's window: here the result alone is written"
  edit_parameter "$name" "$value"
}
whole_number() {
  case $2 in '' | *[!0-9]*) die "$1 needs a whole number, not '$2'" ;; esac
}

left=$#
while [ "$left" -gt 0 ]; do
  argument=$1
  shift
  left=$((left - 1))
  case $argument in
    -o | -j | --threads | --time-limit | --set)
      value_of "$argument" "$left"
      value=$1
      shift
      left=$((left - 1))
      case $argument in
        -o)
          [ -n "$value" ] || die "-o needs a name"
          output=$value
          ;;
        -j)
          whole_number -j "$value"
          [ "$value" -gt 0 ] || die "-j needs 1 or more"
          jobs=$value
          ;;
        --time-limit)
          whole_number --time-limit "$value"
          time_limit=$value
          ;;
        --threads)
          whole_number --threads "$value"
          set_parameter "Threads=$value"
          ;;
        --set) set_parameter "$value" ;;
      esac
      ;;
    --paper) edit_parameter Method 1 ;;
    --surface) edit_parameter StopAtParametricSurface true ;;
    --leave-open) edit_parameter Openings 1 ;;
    -h | --help)
      usage
      exit 0
      ;;
    --)
      while [ "$left" -gt 0 ]; do
        set -- "$@" "$1"
        shift
        left=$((left - 1))
      done
      ;;
    -*) die "unknown option $argument (see --help)" ;;
    *) set -- "$@" "$argument" ;;
  esac
done

read_formats="ply, obj, off, stl, xyz, pts, asc and ptx"

# --- inputs: folders become the clouds in them -----------------------------------------------------------------------
results=''
if [ $# -eq 0 ]; then
  set -- "$root/sample_clouds"
  results=$root/sample_clouds/results
fi
several=''
[ $# -eq 1 ] || several=yes
left=$#
while [ "$left" -gt 0 ]; do
  argument=$1
  shift
  left=$((left - 1))
  case $argument in -*) argument=./$argument ;; esac # no option of what it is given to
  if [ ! -d "$argument" ]; then
    set -- "$@" "$argument"
    continue
  fi
  several=yes
  found='' left_alone=0
  for file in "${argument%/}"/*; do
    case $(printf %s "${file##*.}" | tr '[:upper:]' '[:lower:]') in
      ply | obj | off | stl | xyz | pts | asc | ptx)
        case ${file##*/} in *_shrink_wrap.*) continue ;; esac
        if [ -f "$file" ]; then
          set -- "$@" "$file"
          found=yes
        elif [ -e "$file" ]; then
          left_alone=$((left_alone + 1))
        fi
        ;;
      *) [ ! -e "$file" ] || left_alone=$((left_alone + 1)) ;;
    esac
  done
  [ -n "$found" ] || die "no point clouds in the folder $argument: MeshLab reads $read_formats"
  [ "$left_alone" -eq 0 ] || [ "$argument" = "$root/sample_clouds" ] ||
    say "$argument: $left_alone left alone, since they are folders or have other endings (MeshLab reads $read_formats)"
done
case $output in -*) output=./$output ;; esac
if [ -n "$several" ] || [ -d "$output" ] || [ "$output" != "${output%/}" ]; then
  case $output in ?*/) output=${output%/} ;; esac
  results=${output:-$results}
  output=
fi
[ -z "$results" ] || mkdir -p "$results"

# --- set-up --------------------------------------------------------------------------------------------------------
# Later releases of MeshLab have no meshlabserver. Said before anything is installed or built, as far as it can be known.
need_server() {
  command -v meshlabserver >/dev/null 2>&1 || [ -f "$build/CMakeCache.txt" ] || no_server
}
no_server() {
  die "the MeshLab that is installed has no meshlabserver, with which this script works (MeshLab 2020.09 of Debian 12 has" \
    "it, those of 2021 and later have not): apply the filter in MeshLab's window (docs/installing.md) or from Python (docs/pymeshlab.md)"
}
if command -v meshlab >/dev/null 2>&1; then need_server; fi
# shellcheck disable=SC2086  # a list of words
require_packages $host_packages
need_server

# A folder that is there keeps its own choice about tests and warnings: to change it would compile everything again, and
# then once more for tests/run.sh. Only if a warning has stopped the compiler, it is no reason to do without the plugin.
wait_for_others "$build"
if [ -f "$build/CMakeCache.txt" ]; then
  configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON
else
  configure "$build" -DSHRINKWRAP_BUILD_PLUGIN=ON -DSHRINKWRAP_BUILD_TESTS=OFF -DSHRINKWRAP_WARNINGS_AS_ERRORS=OFF
fi
if ! (compile "$build" filter_shrinkwrap_recon) 2>"$work/compile.err"; then
  if ! grep -q -e '\[-Werror' "$build/compile.log"; then
    cat "$work/compile.err" >&2
    exit 1
  fi
  say "Compiling again, as a warning of the compiler stopped it."
  configure "$build" -DSHRINKWRAP_WARNINGS_AS_ERRORS=OFF
  compile "$build" filter_shrinkwrap_recon
fi
[ -x "$build/stage/bin/meshlabserver" ] || no_server

touch "$work/edits.sed"
sed -f "$work/edits.sed" "$script" >"$work/script.mlx"

# --- one input -------------------------------------------------------------------------------------------------------
target_of() { # input
  if [ -n "$output" ]; then
    printf '%s\n' "$output"
    return
  fi
  name=${1##*/}
  folder=$results
  if [ -z "$folder" ]; then
    case $1 in */*) folder=${1%/*} ;; *) folder=. ;; esac
  fi
  printf '%s\n' "${folder:-}/${name%.*}_shrink_wrap.ply"
}

# What the points carry beside coordinates, as far as MeshLab reads it: "vc" for colours, "vq" for qualities. It takes
# colours from PLY, OBJ, OFF and PTX, qualities from PLY, ASC and PTX, and neither from other formats.
carried_by() { # cloud, its ending in small letters
  case $2 in
    ply) # intensities as floats only
      LC_ALL=C sed -n -e '/^end_header/q' -e '1000q' -e '/ intensity/{/ float\(32\)\{0,1\} /!d;}' \
        -e '/^element vertex /,/^element [^v]/s/^property *[a-z0-9]*  *//p' "$1" 2>/dev/null |
        tr -d '\000\r' | sed -n -e 's/^\(red\|diffuse_red\|intensity\) *$/vc/p' -e 's/^\(quality\|confidence\) *$/vq/p'
      ;;
    obj) # v x y z red green blue
      LC_ALL=C awk '/^v[ \t]/ { if (gsub(/[ \t]/, "") >= 6) print "vc"; exit }' "$1" 2>/dev/null
      ;;
    off) # COFF, NCOFF, STCNOFF, ...
      LC_ALL=C awk '!/^[ \t\r]*(#|$)/ { if ($1 ~ /C.*OFF/) print "vc"; exit }' "$1" 2>/dev/null
      ;;
    ptx) echo vc vq ;; # the reflectance is a grey, and a quality
    asc) # x y z quality, commas between them or not
      LC_ALL=C awk '/^[ \t]*[-+.0-9]/ { gsub(/,/, " "); if (NF >= 4) print "vq"; exit }' "$1" 2>/dev/null
      ;;
  esac | sort -u
}

# What the mesh is saved with. Formats that cannot keep it leave it out. The face quality, which tells the faces that span
# openings, is kept by PLY alone.
saving_options() { # cloud, its ending, the mesh's ending
  attributes=$(carried_by "$1" "$2" | tr '\n' ' ')
  case $3 in ply) attributes="$attributes fq" ;; esac
  case $attributes in *[a-z]*) printf '%s\n' "-m $attributes" ;; esac
}

# Runs a command in a process group of its own, so that it can be stopped with all that it started; not at all if `stop`
# has looked for groups already.
in_own_group() { # folder that gets the file `group`, command...
  # shellcheck disable=SC2016  # for the inner shell
  setsid -w sh -c 'echo $$ >"$0/group"; [ ! -e "${0%/*}/stopped" ] || exit 143; exec "$@"' "$@"
}

# Whether there is room for more. The host says that it could not write, but not of the last few thousand bytes of a file.
has_room() { # file to try with
  head -c 65536 /dev/zero 2>/dev/null >"$1" && rm -f "$1"
}

# The first line of a text file, with its number, that begins with a word and has two more after it, but for NaN and
# infinity.
words_in() { # file
  LC_ALL=C grep -naiE '^[[:space:]]*[a-z/][^[:space:]]*[[:space:]]+[^[:space:]]+[[:space:]]+[^[:space:]]' "$1" 2>/dev/null |
    LC_ALL=C grep -vaiE -m 1 '^[0-9]+:[[:space:]]*(nan|inf(inity)?)([[:space:]]|$)' | tr -d '\r' | cut -c 1-60
}

# reconstruct INPUT TARGET FOLDER: writes TARGET only if all went well; FOLDER gets `log`, and `status`, one line.
reconstruct() {
  input=$1 target=$2 job=$3
  give_up() {
    rm -f "$job"/mesh.* "$job/room" # there may be room for nothing else
    printf 'failed: %s\n' "$*" >"$job/status"
    return 1
  }
  case ${target##*/} in *?.?*) ;; *) give_up "$target has no ending that tells the format"; return ;; esac
  case $(printf %s "${target##*.}" | tr '[:upper:]' '[:lower:]') in
    xyz | pts | asc | ptx | txt | csv)
      give_up "a file of the format .${target##*.} has no faces: write the mesh to .ply, .stl, .obj or .off"
      return
      ;;
  esac
  target_folder=.
  case $target in */*) target_folder=${target%/*} ;; esac
  [ -d "${target_folder:-/}" ] || { give_up "there is no folder $target_folder"; return; }
  [ -w "${target_folder:-/}" ] || { give_up "the folder $target_folder cannot be written to"; return; }
  [ ! -d "$target" ] || { give_up "$target is a folder"; return; }

  # What an earlier run left must not pass for the result of this one.
  rm -f "$target"

  [ -e "$input" ] || { give_up "there is no such file"; return; }
  [ -f "$input" ] || { give_up "it is no file"; return; }
  [ -r "$input" ] || { give_up "it cannot be read"; return; }
  [ -s "$input" ] || { give_up "the file is empty"; return; }
  case ${input##*/} in *?.?*) ;; *) give_up "its name has no ending that tells the format"; return ;; esac

  input_ending=$(printf %s "${input##*.}" | tr '[:upper:]' '[:lower:]')
  case $input_ending in
    xyz | pts | asc)
      no_point=$(words_in "$input")
      [ -z "$no_point" ] || {
        give_up "line ${no_point%%:*} (${no_point#*:}) is no point, and MeshLab would read one at the origin: delete such lines"
        return
      }
      ;;
  esac

  # The host meets plain names only: it does not cope with every character, and not in every locale.
  target_ending=$(printf %s "${target##*.}" | tr '[:upper:]' '[:lower:]')
  link=$job/cloud.$input_ending mesh=$job/mesh.$target_ending
  case $input in /*) ln -s "$input" "$link" ;; *) ln -s "$PWD/$input" "$link" ;; esac

  code=0 begun=$(date +%s) options=$(saving_options "$link" "$input_ending" "$target_ending")
  # shellcheck disable=SC2086  # options are words
  (cd "$job" && HOME=$work TMPDIR=$job in_own_group "$job" timeout -k 5 "$time_limit" xvfb-run -a \
    "$build/stage/bin/meshlabserver" -l "$job/host.log" -i "$link" -o "$mesh" $options -s "$work/script.mlx") \
    >"$job/host.out" 2>&1 || code=$?
  rm -f "$job/group"
  touch "$job/host.log"
  # The filter's lines: after its name, to what the host says next.
  sed -n -e '1,/^.*filter: /d' -e '/^Mesh .* saved as /q' -e '/^Problem with filter/q' -e '/^Output mesh /q' \
    -e '/^Failed saving/q' -e p "$job/host.log" >"$job/log"

  reason=$(sed -n -e '/^Shrink Wrap failed: /!d' -e 's/^Shrink Wrap failed: //' -e 's/^layer "[^"]*": //' -e p "$job/log" | tail -n 1)
  verdict=$(sed -n 's/^Shrink Wrap succeeded: //p' "$job/log" | tail -n 1)
  if [ -e "$work/stopped" ]; then
    give_up "stopped"
  elif [ -n "$reason" ]; then
    case $reason in
      "the layer has no points"*)
        reason="MeshLab found no points in it"
        case $input_ending in
          xyz | pts | asc)
            reason="$reason: it takes lines of 3 numbers, or of 6 with normals or colours, with blanks between. Keep the first 3 of each: awk '{print \$1, \$2, \$3}'"
            ;;
        esac
        ;;
    esac
    give_up "$reason"
  elif [ "$time_limit" -gt 0 ] && [ "$(($(date +%s) - begun))" -ge "$time_limit" ] &&
    { [ "$code" -eq 124 ] || [ "$code" -eq 137 ]; }; then
    give_up "not done after $time_limit s"
  elif [ "$code" -eq 137 ]; then
    give_up "MeshLab was killed: for want of memory?"
  elif [ "$code" -gt 128 ] && [ "$code" -lt 192 ]; then
    when=
    grep -q " loaded has " "$job/host.log" || case $input_ending in
      obj) when=" while reading it: MeshLab cannot read an OBJ with a face at its first vertex. Delete its faces, or save it as PLY" ;;
      *) when=" while reading it: is it a point cloud, whole, and of a kind that MeshLab reads (PLY: ASCII or little-endian)?" ;;
    esac
    give_up "MeshLab crashed (signal $((code - 128)))$when"
  elif grep -q "not possible to import mesh" "$job/host.log"; then
    give_up "MeshLab cannot read it: is it a point cloud, whole, in the format that its ending tells, and one of $read_formats?"
  elif [ "$code" -ne 0 ] || [ -z "$verdict" ]; then
    give_up "MeshLab failed (exit $code): $(tail -n 1 "$job/host.log")"
  elif [ ! -s "$mesh" ]; then
    give_up "MeshLab did not write the mesh: can it write the format .${target##*.}?"
  elif ! grep -q '^Mesh .* saved as ' "$job/host.log" || ! has_room "$job/room"; then
    give_up "MeshLab could not write the whole mesh: is ${TMPDIR:-/tmp} full?"
  else
    # Beside the target first, so that a name never stands for half a file; never into a file that is there (-C).
    beside=${target_folder:-}/.shrink_wrap.$$.${job##*/}
    if ! (set -C && : >"$beside") 2>/dev/null; then
      give_up "$target_folder cannot be written to"
    elif cat "$mesh" >"$beside" && mv -f "$beside" "$target"; then
      rm -f "$mesh"
      printf 'done: %s\n' "$verdict" >"$job/status"
    else
      rm -f "$beside"
      give_up "the mesh could not be written to $target"
    fi
  fi
}

# --- all of them, at most $jobs at once, told in order ---------------------------------------------------------------
show() { # number of the input
  job=$work/$1
  input=$(cat "$job/input")
  status=$(cat "$job/status" 2>/dev/null) || status="failed: interrupted"
  printf '\n%s\n' "$input"
  if [ -f "$job/log" ]; then grep -v '^Shrink Wrap ' "$job/log" | sed 's/^/  /' || :; fi
  case $status in
    done:*) printf '  -> %s\n     %s\n' "$(cat "$job/target")" "${status#done: }" ;;
    *)
      failures=$((failures + 1))
      printf '  FAILED: %s\n' "${status#failed: }" >&2
      printf '  %s: %s\n' "$input" "${status#failed: }" >>"$work/failures"
      ;;
  esac
}

# True if writing to the target would destroy one of the inputs, or what another input was made into.
is_taken() { # target, inputs...
  taken=$1
  shift
  place=.
  case $taken in */*) place=${taken%/*}/ ;; esac
  key=$(printf '%s/%s' "$(realpath -m -- "$place")" "${taken##*/}" | tr '\n' '\001')
  if grep -qFx -e "$key" "$work/targets"; then
    reason="another input is written to the same name, $taken: rename one, or give them different folders (-o)"
    return 0
  fi
  printf '%s\n' "$key" >>"$work/targets"
  [ -e "$taken" ] || return 1
  for other in "$@"; do
    # shellcheck disable=SC3013  # -ef: every shell has it
    if [ "$taken" -ef "$other" ]; then
      reason="the mesh would overwrite the cloud $other"
      return 0
    fi
  done
  return 1
}

show_finished() {
  while [ "$shown" -lt "$number" ] && [ -e "$work/$((shown + 1))/seconds" ]; do
    shown=$((shown + 1))
    show "$shown"
  done
}

busy() { # how many are being worked on
  count=0
  for job in $running; do
    if [ -e "$work/$job/seconds" ]; then
      wait "$(cat "$work/$job/pid")" || :
    else
      count=$((count + 1))
      still="$still $job"
    fi
  done
}

: >"$work/targets"
total=$# number=0 shown=0 failures=0 running=''
for input in "$@"; do
  number=$((number + 1))
  job=$work/$number
  mkdir "$job"
  target=$(target_of "$input"; echo .)
  target=${target%??}
  printf '%s' "$input" >"$job/input"
  printf '%s' "$target" >"$job/target"
  if is_taken "$target" "$@"; then
    printf 'failed: %s\n' "$reason" >"$job/status"
    echo 0 >"$job/seconds"
    continue
  fi
  (
    trap : HUP INT TERM PIPE # what is being moved into place is moved; the host is stopped by `stop`
    started=$(date +%s)
    reconstruct "$input" "$target" "$job" || :
    echo $(($(date +%s) - started)) >"$job/seconds.partial"
    mv "$job/seconds.partial" "$job/seconds"
  ) &
  echo $! >"$job/pid"
  running="$running $number"
  while :; do
    still=''
    busy
    running=$still
    show_finished
    [ "$count" -ge "$jobs" ] || break
    sleep 0.1
  done
done
wait
show_finished

# --- summary -----------------------------------------------------------------------------------------------------------
# Names last, and failures once more: in a long list they must be found.
if [ "$total" -gt 1 ]; then
  printf '\n%8s  %-7s %s\n' seconds result input
  number=0
  while [ "$number" -lt "$total" ]; do
    number=$((number + 1))
    job=$work/$number
    status=$(cat "$job/status")
    word=FAILED
    case $status in 'done:'*) word='done' ;; esac
    printf '%8s  %-7s %s (%s)\n' "$(cat "$job/seconds")" "$word" "$(cat "$job/input")" "${status#*: }"
  done
  printf '\n%d of %d reconstructed\n' $((total - failures)) "$total"
  if [ "$failures" -gt 0 ]; then
    printf 'Failed:\n' >&2
    cat "$work/failures" >&2
  fi
fi
[ "$failures" -eq 0 ]
