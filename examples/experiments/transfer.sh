#!/usr/bin/env bash
# The matrix of transfer: a camouflage for each detector, measured with each, on held-out drawn streets and, if named, on
# frames of your own. Beside every rate stands the matched control: noise with the colours and the spectrum of that very
# camouflage, laid out by chance. What is there is not done again, so that an interrupted matrix goes on.
#
#   transfer.sh OUTPUT MESH LENGTH NAME=DETECTOR NAME=DETECTOR...
#
# OUTPUT    folder for everything; the table is OUTPUT/transfer.md
# MESH      options of camouflage that say which mesh is painted where, one argument: "--mesh car.obj --faces body.txt"
# LENGTH    metres of the mesh's longest side; 0: its units are metres
# DETECTOR  options of camouflage that say which detector: "--weights yolox_nano.onnx --names coco.names"
# Paths must have no spaces. In the environment: TRAIN, TEST (frames), EPOCHS, TEXELS, SEED, SIZE (of frames, pixels), and
# FRAMES, a folder of frames of the same car that nothing was optimised on.
set -euo pipefail
export LC_ALL=C  # numbers with points
[ $# -ge 4 ] || { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2; }
programs=$(cd "$(dirname "$0")/../.." && pwd)/build/release/examples
output=$1
read -ra mesh <<<"$2"
length=$3
shift 3
[ -x "$programs/make_dataset" ] || { echo "error: $programs/make_dataset is not built; examples/run.sh builds camouflage, cmake --build --preset release all" >&2; exit 2; }

mkdir -p "$output"
if [ ! -e "$output/frames/done" ]; then
  "$programs/make_dataset" "${mesh[@]}" --length "$length" --train "${TRAIN:-300}" --test "${TEST:-80}" --size "${SIZE:-416}" \
    --seed "${SEED:-1}" --output "$output/frames"
  touch "$output/frames/done"
fi
sets=("$output/frames" ${FRAMES:+"$FRAMES"})

# Of a table metrics.csv, "detected/views (mean best confidence)" of a row.
cell() { awk -F, -v row="$2" '$1 == row { printf "%d/%d (%.3f)", $3, $2, $7 }' "$1/metrics.csv"; }
effect() { sed -n 's/.*beyond matched noise: mean best confidence \([^,]*, [^]]*\]\).*/\1/p' "$1/printed.txt"; }

table=$output/transfer.md
{
  echo "| made for | measured with | frames | clean | camouflage | matched noise | shuffled | random | effect [95 %] |"
  echo "|---|---|---|---|---|---|---|---|---|"
} >"$table.part"
for made in "$@"; do
  read -ra detector <<<"${made#*=}"
  run=$output/run-${made%%=*}
  if [ ! -e "$run/metrics.json" ]; then
    resume=()
    [ ! -e "$run/manifest.json" ] || resume=(--resume)
    "$programs/camouflage" "${mesh[@]}" "${detector[@]}" --frames "$output/frames" --epochs "${EPOCHS:-6}" \
      --texels "${TEXELS:-128}" --seed "${SEED:-1}" --output "$run" "${resume[@]}"
  fi
  for measured in "$@"; do
    read -ra detector <<<"${measured#*=}"
    for i in "${!sets[@]}"; do
      result=$output/${made%%=*}-${measured%%=*}-$i
      if [ ! -e "$result/done" ]; then
        mkdir -p "$result"
        "$programs/evaluate" --run "$run" "${detector[@]}" --frames "${sets[$i]}" --output "$result" >"$result/printed.txt"
        touch "$result/done"
      fi
      echo "| ${made%%=*} | ${measured%%=*} | $(basename "${sets[$i]}") | $(cell "$result" clean) |" \
        "$(cell "$result" adversarial) | $(cell "$result" "matched noise") | $(cell "$result" shuffled) |" \
        "$(cell "$result" random) | $(effect "$result") |" >>"$table.part"
    done
  done
done
{
  echo
  echo "Cells: views in which the detector finds the car at confidence .25 with IoU at least .5, of all views (mean best"
  echo "confidence). Effect: matched noise minus camouflage, mean best confidence, paired bootstrap over views."
} >>"$table.part"
mv "$table.part" "$table"
cat "$table"
echo "table: $table"
