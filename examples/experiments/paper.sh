#!/usr/bin/env bash
# Every table of the FCA paper and its figure of attention, and an eighth: effect against resolution. Files that exist are
# not made again: an interrupted command continues, and ends with the same files. One command at a time works in a folder,
# and files that its steps read must not change.
#
#   paper.sh OUTPUT [--quick] [--tables "1 8"]
#
# OUTPUT    folder for everything; OUTPUT/tables/index.html is a page over all tables, with CSV, JSON, Markdown, LaTeX and SVG
# --quick   one seed, 5 draws of noise, few steps, frames and views: a first look
# --tables  only these: 1 methods, 2 photographed, 3 views, 4 occlusion, 5 hard examples, 6 terms of the loss, 7 first
#           textures, 8 resolution, attention
# Paths must have no spaces, quotes or backslashes; give relative ones from the folder where the first command was started. In
# the environment: COMMON (options of camouflage: mesh, detector), FRAMES (folder with train and test; else streets are
# drawn with the mesh, of LENGTH metres), FURTHER (weights of further detectors that measure, too), COARSE (options of the
# row coarse), SEEDS ("1 2 3"), DRAWS of matched noise (20), EPOCHS, VALIDATION (views on which the best epoch is chosen),
# TUNE (learning rates and weights of smoothness of which each method gets its best, such as "0.03/1 0.1/1 0.1/0"; needs
# VALIDATION), HARD_FOR (detectors of table 5; all), VIEWS=quick (fewer of them in tables 2 to 4), LAUNCH ("mpirun -n 4
# --bind-to none").
set -euo pipefail
[ $# -ge 1 ] && [ "${1:0:1}" != - ] || { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2; }
output=$1 quick=() tables="1 2 3 4 5 6 7 8 attention"
command_line="paper.sh $*"
shift
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=(--quick) ;;
    --tables) tables=${2:?--tables needs a list}; shift ;;
    *) echo "error: $1 is not an option of paper.sh" >&2; exit 2 ;;
  esac
  shift
done
if [ ${#quick[@]} -gt 0 ]; then
  train=200 test=20 epochs=8 seeds_default=1 draws=5
else
  train=800 test=80 epochs=20 seeds_default="1 2 3" draws=20
fi
read -ra common <<<"${COMMON:-}"
read -ra further <<<"${FURTHER:-}"
read -ra coarse <<<"${COARSE:---texels 16 --conditions camera}"
read -ra seeds <<<"${SEEDS:-$seeds_default}"
draws=${DRAWS:-$draws} plain_of=fca
source "$(dirname "$0")/steps.sh"
settle "$(printf '%s; ' "${quick[*]}" "${COMMON:-}" "${FRAMES:-}" "${LENGTH:-}" "${FURTHER:-}" "${coarse[*]}" "${EPOCHS:-$epochs} passes, $draws draws" \
  "${VALIDATION:-no} views of validation" "tuned: ${TUNE:-no}" "${VIEWS:-}" "${HARD_FOR:-}")"
[ -z "${TUNE:-}" ] || [ -n "${VALIDATION:-}" ] || fail 2 "TUNE needs VALIDATION"

# Options of COMMON that choose the mesh in the streets, and those that further detectors share.
mesh=() shared=()
for ((i = 0; i < ${#common[@]}; i++)); do
  case ${common[i]} in
    --mesh | --faces | --up | --forward) mesh+=("${common[i]}" "${common[i + 1]}") ;;
    --names | --class | --size | --confidence | --nms | --precision) shared+=("${common[i]}" "${common[i + 1]}") ;;
  esac
done
frames=${FRAMES:-$output/frames}
if [ -z "${FRAMES:-}" ] && [ ! -e "$output/frames.done" ]; then
  run "$output/frames.txt" "$programs/make_dataset" "${mesh[@]}" ${LENGTH:+--length "$LENGTH"} --train "$train" --test "$test" \
    --seed 1 --output "$frames"
  touch "$output/frames.done"
fi
common+=(--epochs "${EPOCHS:-$epochs}" ${VALIDATION:+--validation "$VALIDATION"})
filter=(--filter anisotropic) # of every measurement, though mesh_adv is optimised with another
[[ " ${COMMON:-} " != *" --filter "* ]] || filter=()
as_photographed=(--light frame "${filter[@]}") # though rauca is optimised in another light

declare -A options=([coarse]="${coarse[*]}" [conditions]="--conditions physical"
  [cls]="--loss paper --iou-weight 0 --objectness-weight 0 --smoothness-weight 1"
  [obj]="--loss paper --iou-weight 0 --class-weight 0 --smoothness-weight 1"
  [iou]="--loss paper --objectness-weight 0 --class-weight 0 --smoothness-weight 1"
  [cls+obj]="--loss paper --iou-weight 0 --smoothness-weight 1"
  [all]="--loss paper --smoothness-weight 0"
  [all+smooth]="--loss paper --smoothness-weight 1" [vanish]="--loss vanish" [random_start]="--start random" [own_start]="--start own")
methods=() designs=() # all methods, and those but for noise and plain colours
while read -r name usual; do
  [ -z "${TUNE:-}" ] || usual=${usual/--smoothness-weight 0/}
  methods+=("$name") options[$name]="--method $name $usual"
  [[ $name == @(random|solid) ]] || designs+=("$name")
done < <("$programs/camouflage" --list-methods)
for texels in 8 16 32 64 128; do options[rows_$texels]="--texels $texels"; done

# Words of a setting RATE/WEIGHT of TUNE, but for what a camouflage's own options state.
words_of() { # SETTING OWN...
  [[ " ${*:2} " == *" --learning-rate "* ]] || echo "--learning-rate ${1%/*}"
  [[ " ${*:2} " == *" --smoothness-weight "* ]] || echo "--smoothness-weight ${1#*/}"
}
# Prints whose trials set a camouflage's options: those of its method, or else those of fca.
tuned_as() { # NAME
  [[ " ${methods[*]} " == *" $1 "* ]] && echo "$1" || echo fca
}
# Tries the settings with the first seed, at half of the passes. The best has the least term max_score on the views of
# validation.
best_setting() { # NAME
  local setting trial score least= own seeds=("${seeds[0]}")
  best=
  read -ra own <<<"${options[$1]}"
  for setting in ${TUNE:-}; do
    trial=$1-${setting/\//-}
    optimise "$trial" --frames "$frames" "${own[@]}" $(words_of "$setting" "${own[@]}") --epochs $(((${EPOCHS:-$epochs} + 1) / 2))
    score=$(sed -nE 's/^ *"best_max_score": ([-+.0-9e]+),?$/\1/p' "$output/runs/$trial-${seeds[0]}/metrics.json")
    if [ -z "$least" ] || awk "BEGIN { exit !($score < $least) }"; then least=$score best=$setting; fi
  done
}

# Optimises a camouflage of the list above.
paint() { # [LABEL:]NAME
  local name=${1##*:} own best=
  read -ra own <<<"${options[$name]}"
  [ "$name" = random ] || best_setting "$(tuned_as "$name")"
  [ -z "$best" ] || own+=($(words_of "$best" "${own[@]}"))
  optimise "$name" --frames "$frames" "${own[@]}"
}
table_of_photographs() { # NAME TITLE PROTOCOL ROW...
  local rows=() name
  for name in "${@:4}"; do
    paint "$name"
    measure_photographs "${name##*:}" "$3" "${as_photographed[@]}"
    rows+=("$(row "$3" "$name")")
  done
  tabulate "$1" "$2" "${rows[@]}"
}

# Measures a camouflage by a protocol on renders, once with each detector.
measure_renders() { # NAME PROTOCOL
  local seed weights background=(--background 0.5 0.5 0.5)
  [ "$2" != physical ] || background=()
  [ "${VIEWS:-}" != quick ] || background+=(--quick)
  for seed in "${seeds[@]}"; do
    measure "$2" "$1-$seed" "$output/runs/$1-$seed" "${background[@]}" "${filter[@]}"
    for weights in "${further[@]}"; do
      measure "$2" "$1-$seed-$(basename "${weights%.*}")" "$output/runs/$1-$seed" "${background[@]}" "${filter[@]}" \
        --weights "$weights" "${shared[@]}"
    done
  done
}
table_of_renders() { # NAME TITLE PROTOCOL ROW...
  local rows=() name weights suffixes=("")
  for weights in "${further[@]}"; do suffixes+=("-$(basename "${weights%.*}")"); done
  for name in "${@:4}"; do
    paint "$name"
    measure_renders "$name" "$3"
    rows+=("$(row "$3" "$name" "${suffixes[@]}")")
  done
  tabulate "$1" "$2" "${rows[@]}"
}

table_1() { table_of_photographs 1-methods "Table 1: methods, as they are" digital "${designs[@]}" coarse noise:random solid; }
table_2() { table_of_renders 2-physical "Table 2: printed and photographed, simulated" physical "${designs[@]}" coarse conditions; }
table_3() { table_of_renders 3-views "Table 3: from all around, near and far" views fca coarse; }
table_4() { table_of_renders 4-occlusion "Table 4: partly hidden" occlusion fca coarse; }
table_6() { table_of_photographs 6-losses "Table 6: terms of the loss" digital cls obj iou cls+obj all all+smooth max_score:fca vanish; }
table_7() { table_of_photographs 7-starts "Table 7: first textures" digital "the car's own:own_start" "drawn at random:random_start" "zero (grey):fca"; }
table_8() {
  local rows=() texels default=64 # rows of fca
  [[ ! " ${COMMON:-} " =~ " --texels "([0-9]+) ]] || default=${BASH_REMATCH[1]}
  for texels in 8 16 32 64 128; do
    [ "$texels" = "$default" ] && rows+=("$texels:fca") || rows+=("$texels:rows_$texels")
  done
  table_of_photographs 8-resolution "Table 8: effect against resolution, rows of the atlas" digital "${rows[@]}"
}
table_attention() { table_of_photographs 9-attention "What detectors look at" attention fca das_full coarse; }

# Hard examples: the camouflage is optimised further on the training frames where a detector still finds it, and as a
# control on as many others.
table_5() {
  local seed detector detectors names=() rows name
  paint fca
  measure_photographs fca digital "${as_photographed[@]}"
  for seed in "${seeds[@]}"; do
    measure digital "fca-$seed-train" "$output/runs/fca-$seed" ${further[@]:+--further-weights "${further[@]}"} \
      "${as_photographed[@]}" --frames "$frames/train"
  done
  detectors=$(awk -F , 'NR > 1 && !seen[$1]++ { print $1 }' "$output/measured/digital-fca-${seeds[0]}-train/photographs.csv")
  for detector in ${HARD_FOR:-$detectors}; do
    [[ $'\n'$detectors$'\n' == *$'\n'$detector$'\n'* ]] || fail 2 "HARD_FOR: $detector is none of $(paste -s -d ' ' <<<"$detectors")"
    for seed in "${seeds[@]}"; do
      further_frames "$detector" "$seed"
      if [ ! -s "$output/frames-hard_$detector-$seed/list.txt" ] || [ ! -s "$output/frames-others_$detector-$seed/list.txt" ]; then
        echo "$detector finds the camouflage of seed $seed in none or all of the frames that it was optimised on: no row in table 5"
        continue 2
      fi
    done
    for name in "hard_$detector" "others_$detector"; do
      for seed in "${seeds[@]}"; do further_run "$name" "$seed"; done
      names+=("$name")
    done
  done
  rows=("$(row digital fca)")
  for name in "${names[@]}"; do
    measure_photographs "$name" digital "${as_photographed[@]}"
    rows+=("$(row digital "$name")")
  done
  tabulate 5-hard "Table 5: optimised further on hard examples of each detector" "${rows[@]}"
}
# Two folders of frames to optimise on: those where the detector finds the camouflage, and at most as many others.
# Their lists may be empty.
further_frames() { # DETECTOR SEED
  local csv=$output/measured/digital-fca-$2-train/photographs.csv folder path name found
  for name in hard others; do
    folder=$output/frames-${name}_$1-$2
    [ ! -e "$folder/done" ] || continue
    rm -rf "$folder"
    mkdir -p "$folder/train"
    [ $name = hard ] && found=1 || found=0
    awk -F , -v detector="$1" '$1 == detector && $2 == "adversarial" { path = $0; for (k = 0; k < 7; k++) sub(/^[^,]*,/, "", path)
      gsub(/^"|"$/, "", path); print $3, path }' "$csv" >"$folder/all.txt"
    awk -v found=$found -v seed="$2" '$1 == found { path[++n] = $2 } $1 == 1 { most++ }
      END { srand(seed); for (i = 1; i <= n && i <= most; i++) { j = i + int(rand() * (n - i + 1)); t = path[i]; path[i] = path[j]; path[j] = t; print path[i] } }' \
      "$folder/all.txt" | sort >"$folder/list.txt"
    while read -r path; do ln "$path" "$folder/train/" 2>/dev/null || cp "$path" "$folder/train/"; done <"$folder/list.txt"
    ln -s "$(cd "$frames/test" && pwd)" "$folder/test"
    touch "$folder/done"
  done
}
further_run() { # NAME SEED
  local seeds=("$2") best= own
  best_setting fca
  [ -z "$best" ] || own=($(words_of "$best"))
  optimise "$1" --validation 0 --frames "$output/frames-$1-$2" --start "$output/runs/fca-$2/texture.npz" "${own[@]}"
}

for table in $tables; do
  declare -F "table_$table" >/dev/null || { echo "error: there is no table $table" >&2; exit 2; }
done
for table in $tables; do "table_$table"; done
echo "page over all tables: $output/tables/index.html"
