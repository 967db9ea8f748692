#!/usr/bin/env bash
# Every figure of docs/EXPERIMENTS.md, in a night on two cores. An interrupted command goes on, and ends with the same files.
#
#   page.sh OUTPUT [--quick] DETECTOR DETECTOR DETECTOR...
#
# OUTPUT    folder for everything; OUTPUT/*/tables/index.html are pages over the tables, OUTPUT/results holds what the page cites
# --quick   few frames, one seed, short runs, one of the paper's tables: shows that everything runs
# DETECTOR  .onnx models that take pictures of 416 pixels: paints are made for the first, with
#           the second for ensembles of two and with the third for those of three; all measure, as they are and made sound
# Paths must have no spaces, quotes or backslashes. In the environment: CAR (options --mesh and --faces or --material; the
# bundled sedan), LENGTH (its metres), NAMES (file of the detectors' classes), SEEDS ("1 2 3"), DRAWS of matched noise (3),
# EPOCHS (4), SIZE of pictures (416), TABLES (of paper.sh), PROGRAMS, LAUNCH, PARTS (sound tables stronger hardened world
# results), BACKGROUNDS (folder of photographs without cars, named by place, for the part world; else it is left out) and VIEW
# (their camera, as options of make_dataset).
set -euo pipefail
usage() { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2; }
[ $# -ge 4 ] || usage
here=$(dirname "$0") output=$1
shift
frames=(--train 300 --test 80) world=(--train 300 --test 100) passes=()
validation=40 tune="0.1/10 0.3/0 0.3/1 0.3/10 0.3/30 0.3/100 1/10" tables="8 1 6 2 3 4 7 5 attention" seeds="1 2 3"
draws=3 epochs=4 tuning=() hardening=(--rounds 5 --steps 80 --attack-steps 50 --pictures 8)
if [ "$1" = --quick ]; then
  frames=(--train 24 --test 8) world=(--train 16 --test 4) passes=(--epochs 1)
  validation=4 tune="0.3/30" tables=8 seeds=1 draws=2 epochs=1 tuning=(--steps 4 --pictures 4 --clean-scenes 4 --test-scenes 4)
  hardening=(--rounds 1 --steps 2 --attack-steps 2 --pictures 2 --clean-scenes 4 --test-scenes 4)
  shift
fi
[ $# -ge 3 ] || usage
detectors=("$@") sound=() size=(--size "${SIZE:-416}")
export SEEDS=${SEEDS:-$seeds} DRAWS=${DRAWS:-$draws} EPOCHS=${EPOCHS:-$epochs}
read -ra mesh <<<"${CAR:-}"
car=("${mesh[@]}" ${NAMES:+--names "$NAMES"} "${size[@]}")
source "$here/steps.sh"
settle "$(printf '%s; ' "${frames[*]}" "${car[*]}" "${LENGTH:-}" "${tuning[*]} ${hardening[*]}" "$SEEDS" \
  "$DRAWS draws, $EPOCHS passes" "tuned: $tune" "${detectors[*]}" "${BACKGROUNDS:-} ${VIEW:-}")"
if [ ! -e "$output/frames.done" ]; then
  "$programs/make_dataset" "${mesh[@]}" ${LENGTH:+--length "$LENGTH"} "${frames[@]}" --seed 1 --output "$output/frames"
  touch "$output/frames.done"
fi
for detector in "${detectors[@]}"; do
  sound+=("$output/sound/$(basename "${detector%.*}")-sound.${detector##*.}")
done
export COMMON="${car[*]} --weights ${sound[0]} --texels 128" FRAMES=$output/frames FURTHER="${sound[*]:1} ${detectors[*]}"

# The detectors, fine-tuned without any attack until they find the plain car.
part_sound() { "$here/sound.sh" "$output/sound" "${mesh[@]}" "${size[@]}" "${tuning[@]}" --frames "$output/frames" -- "${detectors[@]}"; }
part_tables() {
  VALIDATION=$validation TUNE=$tune VIEWS=quick HARD_FOR=$(basename "${sound[0]%.*}") \
    "$here/paper.sh" "$output/paper" --tables "${TABLES:-$tables}"
}
# The options that the search of the tables has chosen for fca.
chosen() {
  sed -nE 's/^ *"(learning-rate|smoothness-weight)": ([0-9.]+),?$/--\1 \2/p' "$output/paper/runs/fca-${SEEDS%% *}/manifest.json" 2>/dev/null |
    paste -s -d ' ' || fail 2 "part tables comes first, whose search chooses learning rate and smoothness"
}
# The strongest paint at equal steps; uses the paints of the tables. Paints for three leave out detector 4, 3, 2 or 1.
part_stronger() {
  strong=$(chosen)
  mkdir -p "$output"/stronger/{runs,measured}
  for made in "$output"/paper/{runs/{fca,vanish,conditions},measured/digital-{fca,vanish}}-[0-9]; do
    to=$output/stronger/${made#"$output/paper/"}
    [ ! -e "$made" ] || [ -e "$to" ] || ln -sr "$made" "$to"
  done
  "$here/variants.sh" "$output/stronger" "$COMMON --frames $FRAMES --epochs $EPOCHS --validation $validation $strong" fca= \
    less_smooth="--smoothness-weight 1" for_two="--ensemble ${sound[1]}" for_three="--ensemble ${sound[*]:1:2}" \
    without_third="--ensemble ${sound[1]} ${sound[*]:3}" without_second="--ensemble ${sound[*]:2}" \
    without_first="--weights ${sound[1]} --ensemble ${sound[*]:2}" paper="--loss paper" vanish="--loss vanish" \
    camera="--conditions camera" camera_for_three="--conditions camera --ensemble ${sound[*]:1:2}" \
    conditions="--conditions physical" worst_half="--worst-views 0.5"
}
# The first detector hardened against paint, and its control of as many steps without; both are attacked afresh.
part_hardened() {
  local kind folder resume
  strong=$(chosen)
  for kind in none optimised; do
    folder=$output/hardened/$kind resume=()
    [ ! -e "$folder/metrics.json" ] || continue
    [ ! -e "$folder/manifest.json" ] || resume=(--resume)
    "$programs/harden" "${car[@]}" --weights "${sound[0]}" --frames "$output/frames" --texels 128 --paint $kind \
      "${hardening[@]}" $strong --weight-rate 0.0003 --epochs "$EPOCHS" --output "$folder" "${resume[@]}"
  done
}
# A table of runs of harden: P@0.5 of each picture before and after, and the results in the drawn scenes.
table_of_hardening() { # NAME TITLE RUN...
  local file=$output/results/$1 run label
  echo "detector,$(head -n 1 "$3/metrics.csv")" | sed 's/,detector,/,state,/' >"$file.csv"
  for run in "${@:3}"; do sed "1d;s/^/$(basename "$run"),/" "$run/metrics.csv"; done >>"$file.csv"
  {
    printf '# %s\n' "$2"
    for run in "${@:3}"; do
      label=$(basename "$run")
      printf '\n**%s**\n' "$label"
      sed -n "/^|/{s/^| \([a-z ]*\): [^|]*/| $label, \1 /;p;};/^on [0-9]* clean\|^hardened minus/s/^/\n/p" "$run/report.md" | sed '1s/^/\n/'
    done
    printf '\nMade by commit %s.\n' "$(for run in "${@:3}"; do sed -nE 's/^ *"commit": "([^"]*)",$/\1/p' "$run/metrics.json"; done | sort -u | paste -s -d ' ')"
  } >"$file.md"
}
# Tables 3 (by distance) and 4 (by what is hidden), too: the paint of table 1, all seeds, measured by its own detector.
by_distance() { # TABLE
  local files=($(for seed in $SEEDS; do echo "$output/paper/measured/${1#*-}-fca-$seed/${1#*-}.csv"; done))
  awk -F , -v table="$1" 'function share(texture) { return all[key[i], texture] ? sprintf("%.1f", 100 * some[key[i], texture] / all[key[i], texture]) : "-" }
    FNR > 1 { name = table == "3-views" ? $2 : $1 ", " $2; if (!seen[name]++) key[++n] = name
      some[name, $3] += $3 == "clean" ? $7 : $13; all[name, $3] += $3 == "clean" ? $4 : $12 }
    END { print "\n| fca at distance | clean found, % | attack success, % | of matched noise, % |\n|---|---:|---:|---:|"
      for (i = 1; i <= n; i++) print "| " key[i] " | " share("clean") " | " share("adversarial") " | " share("matched noise") " |" }' \
    "${files[@]}" >>"$output/results/$1.md"
  cp "${files[0]/%csv/svg}" "$output/results/$1-fca.svg"
}
# A world that was not drawn: the car in photographs, those of some places held out. Nobody tunes the detectors; paints are
# made by the program's defaults, for the first detector and for all but one.
part_world() {
  [ -n "${BACKGROUNDS:-}" ] || return 0
  local view i others variants=(fca=)
  read -ra view <<<"${VIEW:-}"
  mkdir -p "$output/world"
  if [ ! -e "$output/world/frames.done" ]; then
    "$programs/make_dataset" "${mesh[@]}" ${LENGTH:+--length "$LENGTH"} --backgrounds "$BACKGROUNDS" "${view[@]}" "${world[@]}" \
      --seed 1 --output "$output/world/frames"
    touch "$output/world/frames.done"
  fi
  for i in "${!detectors[@]}"; do
    others=("${detectors[@]:0:i}" "${detectors[@]:i+1}")
    variants+=("without_$(basename "${detectors[i]%.*}")=--weights ${others[0]} --ensemble ${others[*]:1}")
  done
  NAME=world TITLE="In photographs" FURTHER="${detectors[*]:1}" "$here/variants.sh" "$output/world" \
    "${car[*]} --weights ${detectors[0]} --frames $output/world/frames ${passes[*]}" "${variants[@]}"
}
# Everything that the page cites, in one folder.
part_results() {
  local file detector runs=()
  mkdir -p "$output/results"
  for file in "$output"/paper/tables/*.{csv,md,svg} "$output"/stronger/tables/variants.{csv,md,svg}; do cp "$file" "$output/results"; done
  [ -z "${BACKGROUNDS:-}" ] || cp "$output"/world/tables/world.{csv,md,svg} "$output/results"
  for file in 3-views 4-occlusion; do [ ! -e "$output/results/$file.md" ] || by_distance $file; done
  for detector in "${detectors[@]}"; do runs+=("$output/sound/$(basename "${detector%.*}")"); done
  table_of_hardening sound "Detectors fine-tuned without an attack" "${runs[@]}"
  table_of_hardening hardened "Hardened, and the control" "$output"/hardened/{none,optimised}
  # The hardened detector beyond its control, under the adaptive attack, by Newcombe (1998), method 10, of independent shares.
  awk -F , '$2 $3 == "hardenedadaptive" { more = $6 - p; left = low; right = high; p = $6; low = p - $7; high = $8 - p }
    END { printf "\n| hardened | points, 95 %% |\n|---|---:|\n| %s minus none, adaptive | %.1f [%.1f, %.1f] |\n", $1, 100 * more,
      100 * (more - sqrt(low ^ 2 + right ^ 2)), 100 * (more + sqrt(high ^ 2 + left ^ 2)) }' \
    "$output/results/hardened.csv" >>"$output/results/hardened.md"
}
for part in ${PARTS:-sound tables stronger hardened world results}; do "part_$part"; done
