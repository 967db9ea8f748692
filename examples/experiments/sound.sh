#!/usr/bin/env bash
# Sound detectors: fine-tunes each on drawn streets with cars of ordinary colours, without any attack, until a paint has
# something to hide. Says how often each finds the clean car before and after, its average precision and its false alarms.
#
#   sound.sh OUTPUT [OPTIONS OF harden...] -- DETECTOR...
#
# OUTPUT    folder for everything: OUTPUT/NAME-sound.onnx is a detector, OUTPUT/NAME its run
# DETECTOR  .onnx models
# Paths must have no spaces. In the environment: NAMES (file of the classes' names, for detectors without them), PROGRAMS.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2; }
programs=${PROGRAMS:-$(dirname "$0")/../../build/release/examples}
output=$1 options=() names=(${NAMES:+--names "$NAMES"})
shift
while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
[ $# -ge 2 ] || { echo "sound.sh: expected -- and detectors" >&2; exit 2; }
shift
twice=$(for detector in "$@"; do basename "${detector%.*}"; done | sort | uniq -d)
[ -z "$twice" ] || { echo "sound.sh: two detectors are called $twice, and so would be their folders" >&2; exit 2; }
defaults=(--rounds 1 --steps 120 --weight-rate 0.0003 --test-scenes 100)
[[ " ${options[*]} " == *" --frames "* ]] || defaults+=(--scenes 300) # of the bundled car
for ((i = 0; i < ${#defaults[@]}; i += 2)); do
  [[ " ${options[*]} " == *" ${defaults[i]}"[\ =]* ]] || options+=("${defaults[@]:i:2}")
done
mkdir -p "$output"
for detector in "$@"; do
  folder=$output/$(basename "${detector%.*}") resume=()
  if [ ! -e "$folder/metrics.json" ]; then
    [ ! -e "$folder/manifest.json" ] || resume=(--resume)
    "$programs/harden" "${resume[@]}" --weights "$detector" "${names[@]}" --paint none --attacks none "${options[@]}" \
      --output "$folder"
  fi
  [ -e "$folder-sound.onnx" ] || { cp "$folder/hardened.onnx" "$folder-sound.part" && mv "$folder-sound.part" "$folder-sound.onnx"; }
  echo "$folder-sound.onnx"
  sed -n '/^ *\(photo\|clean\) /p;/drawn scenes/p' "$folder/report.txt"
done
