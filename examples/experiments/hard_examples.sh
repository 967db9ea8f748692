#!/usr/bin/env bash
# Hard examples (FCA, table 5): the frames of a run's own training folder in which some detector still finds its camouflage,
# optimised on further, and beside it as many frames drawn by chance, in as many steps; all three measured on held-out frames.
#   hard_examples.sh OUTPUT RUN [COMMON]
# OUTPUT  folder for everything; the table is OUTPUT/hard_examples.md
# RUN     folder of a camouflage that was optimised on frames of a folder, train and test
# COMMON  options of camouflage that RUN was made with, its mesh, detector, texels and so on, one argument; this script adds
#         --frames, --start, --epochs, --seed and --output
# Paths must have no spaces. In the environment: FURTHER (weights of further detectors whose failures count and that measure,
# too), EPOCHS (over the hard frames, 3), SEED. What is there is not done again, so that an interrupted table goes on.
set -euo pipefail
export LC_ALL=C  # numbers with points
[ $# -ge 2 ] || { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2; }
programs=$(cd "$(dirname "$0")/../.." && pwd)/build/release/examples
output=$1
run=$2
read -ra common <<<"${3:-}"
read -ra further <<<"${FURTHER:-}"
[ -x "$programs/evaluate" ] || { echo "error: $programs/evaluate is not built; examples/run.sh builds camouflage, cmake --build --preset release all" >&2; exit 2; }
[ -e "$run/manifest.json" ] || { echo "error: $run holds no run" >&2; exit 3; }
frames=$(sed -n 's/^ *"frames": "\(.*\)",$/\1/p' "$run/manifest.json" | head -n 1)
[ -d "$frames/train" ] && [ -d "$frames/test" ] || { echo "error: $run was not optimised on a folder with train and test" >&2; exit 4; }

for option in frames start epochs seed output; do
  [[ " ${common[*]} " != *" --$option"[\ =]* ]] || { echo "error: --$option is this script's to give, see the head of it" >&2; exit 2; }
done
frame_options=()
[[ " ${common[*]} " != *" --mask file "* && " ${common[*]} " != *" --mask=file "* ]] || frame_options=(--mask file)

mkdir -p "$output"
settings="$run ${common[*]}; further ${further[*]}; ${EPOCHS:-3} passes, seed ${SEED:-1}, $(sha256sum <"$run/texture.npz")"
[ -e "$output/settings" ] || printf '%s\n' "$settings" >"$output/settings"
[ "$(cat "$output/settings")" = "$settings" ] ||
  { printf 'error: %s holds a table of other settings: %s; found %s\n' "$output" "$(cat "$output/settings")" "$settings" >&2; exit 7; }

measure() { # FOLDER RUN FRAMES
  [ -e "$1/photographs.csv" ] || "$programs/evaluate" --run "$2" --protocol digital --controls matched --frames "$3" \
    ${further[@]:+--further-weights "${further[@]}"} --output "$1" >"$output/printed.txt"
}

# The frame is the last field of photographs.csv, in quotes where it needs them.
frame='function frame(row) { sub(/^[^,]*,[^,]*,[^,]*,[^,]*,[^,]*,[^,]*,[^,]*,/, "", row)
  if (row ~ /^"/) { row = substr(row, 2, length(row) - 2); gsub(/""/, "\"", row) } return row }'

measure "$output/train" "$run" "$frames/train"
if [ ! -e "$output/hard/done" ]; then
  rm -rf "$output/hard" "$output/chance"
  mkdir -p "$output/hard/train" "$output/chance/train"
  awk -F , "$frame"' $2 == "adversarial" && $3 == 1 && !seen[frame($0)]++ { print frame($0) }' "$output/train/photographs.csv" | sort >"$output/hard.txt"
  hard=$(wc -l <"$output/hard.txt")
  [ "$hard" -gt 0 ] || { echo "no detector finds the camouflage in any frame that it was optimised on: there are no hard examples"; exit 0; }
  awk -F , "$frame"' NR > 1 && !seen[frame($0)]++ { print frame($0) }' "$output/train/photographs.csv" | sort |
    awk -v n="$hard" -v seed="${SEED:-1}" 'BEGIN { srand(seed) } { path[NR] = $0 }
      END { for (i = 1; i <= n; i++) { j = i + int(rand() * (NR - i + 1)); t = path[i]; path[i] = path[j]; path[j] = t; print path[i] } }' |
    sort >"$output/chance.txt"
  for name in hard chance; do
    while read -r path; do
      files=("$path")
      stem=$(basename "$path" .npz)
      [ ${#frame_options[@]} -eq 0 ] || files+=("$(dirname "$path")/mask${stem#data}.png")
      ln "${files[@]}" "$output/$name/train/" 2>/dev/null || cp "${files[@]}" "$output/$name/train/"
    done <"$output/$name.txt"
    ln -s "$(cd "$frames/test" && pwd)" "$output/$name/test"
  done
  touch "$output/hard/done"
fi

measure "$output/before" "$run" "$frames/test"
for name in hard chance; do
  folder=$output/run-$name
  if [ ! -e "$folder/metrics.json" ]; then
    resume=()
    [ ! -e "$folder/manifest.json" ] || resume=(--resume)
    "$programs/camouflage" "${common[@]}" --frames "$output/$name" --start "$run/texture.npz" --epochs "${EPOCHS:-3}" \
      --seed "${SEED:-1}" --output "$folder" "${resume[@]}"
  fi
  measure "$output/after-$name" "$folder" "$frames/test"
done

table=$output/hard_examples.md
{
  echo "| detector | found in training | before | on hard frames | on as many by chance |"
  echo "|---|---|---|---|---|"
  # Of digital.csv, "detected/frames (mean best confidence)" of the camouflage; names of files say which column.
  awk -F , 'FNR == 1 { file++; next } $3 == "adversarial" { if (file == 1) order[++n] = $2
      cell[$2, file] = sprintf("%d/%d (%.3f)", $7, $4, $11) }
    END { for (i = 1; i <= n; i++) { d = order[i]; print "| " d " | " cell[d, 1] " | " cell[d, 2] " | " cell[d, 3] " | " cell[d, 4] " |" } }' \
    "$output/train/digital.csv" "$output/before/digital.csv" "$output/after-hard/digital.csv" "$output/after-chance/digital.csv"
  echo
  echo "Cells: frames in which the detector finds the camouflage with IoU at least .5, of all frames (mean best confidence);"
  echo "the first on the frames of training, the others on held-out ones. Hard: $(wc -l <"$output/hard.txt") frames in which some"
  echo "detector found it; both continue from the same texture, for ${EPOCHS:-3} passes."
} >"$table.part"
mv "$table.part" "$table"
cat "$table"
echo "table: $table"
