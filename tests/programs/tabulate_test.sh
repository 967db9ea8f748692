#!/usr/bin/env bash
# tabulate puts together only what was measured alike: by the bytes of detectors and frames, not by their names. (F31)
source "$(dirname "$0")/support.sh"
tabulate=$programs/tabulate
assets=$sources/examples/assets
[ -x "$tabulate" ] && [ -e "$assets/detector.weights" ] || exit 77

# Two seeds of a camouflage, by a detector whose file is exchanged later, and a run against the exchanged one.
mkdir frames && cp "$assets"/frames/test/00[01].npz frames
cp "$assets"/detector.{cfg,weights,names} .
cp detector.weights other.weights && printf '\0' | dd of=other.weights bs=1 seek=5000 conv=notrunc status=none
paint() { # FOLDER OPTION...
  "$programs/camouflage" --frames frames --texels 4 --size 64 --epochs 1 --threads 1 --start random --cfg detector.cfg --weights detector.weights --names detector.names \
    "${@:2}" --output "$1" >/dev/null 2>&1 || fail "the run $1"
}
measure() { # FOLDER RUN OPTION...
  "$programs/evaluate" --run "$2" --protocol digital --quick --controls "${controls:-matched}" "${@:3}" --output "$1" >command.out 2>command.err || fail "$1: $(cat command.err)"
}
for seed in 1 2; do paint "run-$seed" --seed $seed && measure "measured-$seed" "run-$seed"; done
paint third --seed 3 --loss vanish
measure third-measured third
measure surer run-2 --confidence 0.01
measure van run-2 --class van
measure few run-2 --noise-draws 2
cp -r measured-1 copied
"$programs/convert_weights" --cfg detector.cfg --weights detector.weights --output second.onnx >/dev/null
measure both-1 run-1 --further-weights second.onnx
"$programs/convert_weights" --cfg detector.cfg --weights other.weights --output second.onnx >/dev/null
measure both-2 run-2 --further-weights second.onnx
mkdir others && cp frames/000.npz others/000.npz && cp "$assets/frames/test/002.npz" others/001.npz
measure elsewhere run-2 --frames others

expect_exit 0 "two seeds and another row" "$tabulate" --output tables row=measured-1,measured-2 other=third-measured
grep -q '^row,detector,adversarial,2,' tables/table.csv && pass || fail "not two seeds: $(head -n 4 tables/table.csv)"
# Each bar of the figure has its interval, as the CSV states it; no table is empty, and each has a title of its own.
awk -F , '$3 == "adversarial" || $3 ~ / noise$/ { printf "%.2f %.2f\n", 270 * $9, 270 * $10 }' tables/table.csv | sort >expected
left=$(sed -nE 's/^<rect x="([0-9.]+)" .*height="9.00".*/\1/p' tables/table.svg | head -n 1)
sed -nE 's/^<path d="M([0-9.]+) ([0-9.]+)L([0-9.]+) \2M.*$/\1 \3/p' tables/table.svg |
  awk -v left="$left" '{ printf "%.2f %.2f\n", $1 - left, $2 - left }' | sort >found
expect_same expected found
awk 'BEGIN { filled = 1 } /^\*\*/ { if (titles[$0]++) exit 1; filled = 1 } /^\|---/ { filled = 0; next } /^\|/ && /[0-9]/ { filled = 1 } /^$/ && !filled { exit 1 }' tables/table.md && pass ||
  fail "tables that are empty, or twice: $(cat tables/table.md)"
# A row without a name has that of its folder; all that lacks is said at once.
expect_exit 0 "rows without names" "$tabulate" --output unnamed measured-1 third-measured/
grep -q '^third-measured,detector,adversarial,1,' unnamed/table.csv && pass || fail "the name of a row: $(cut -d, -f1 unnamed/table.csv)"
expect_exit 2 "runs" "$tabulate" row=run-1,run-2/ third
expect_error_line '^error: run-1 is a run that is not measured yet: evaluate --run run-1 --protocol digital --output run-1-measured, and give that folder; run-2 is .* --output run-2-measured, .*; third is .*; give --output'
# A measurement knows its run from any folder.
mkdir away && (cd away && "$tabulate" --output ../from_away row=../measured-1,../measured-2 other=../third-measured >/dev/null) && pass || fail "from elsewhere"
grep -q "\"name\": \"../run-1\"" from_away/table.json && pass || fail "the run is not found from elsewhere: $(grep -A 3 '"runs"' from_away/table.json)"
# One row alone: two tables, of its textures and of its effects, with the figures that the CSV has.
expect_exit 0 "one row" "$tabulate" --output one row=measured-1,measured-2
[ "$(grep -c '^\*\*' one/table.md)" = 2 ] && ! grep -q '| - |' one/table.md && pass || fail "tables of one row: $(cat one/table.md)"
awk -F , '$3 == "matched noise" { printf "| row, matched noise | %.1f [", 100 * $8 }' one/table.csv >expected
grep -qF "$(cat expected)" one/table.md && pass || fail "not $(cat expected) in $(cat one/table.md)"
expect_exit 0 "a row with a detector more" "$tabulate" --output more row=both-1 other=third-measured
# Colours that are no camouflage's stand in every table where one of its measurements has them; noise drawn in each picture has
# its effect.
controls=all measure all-1 run-1
expect_exit 0 "seeds with other controls" "$tabulate" --output all row=all-1,measured-2 other=third-measured
for name in random white blue; do grep -q "^$name,detector,$name,1,1,2," all/table.csv && pass || fail "no $name in the table"; done
grep -q '^row,detector,picture noise,2,1,4,' all/table.csv && pass || fail "no noise in the pictures"
awk -F , 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
  $1 == "row" && $3 == "adversarial" { found = $at["p_at_50"]; effect = $at["effect_picture"] }
  $1 == "row" && $3 == "picture noise" { exit ($at["p_at_50"] - found - effect) ^ 2 > 1e-12 }' all/table.csv && pass ||
  fail "the effect beyond noise in pictures is not the difference"
grep -q 'effect beyond noise drawn in each picture' all/table.md && pass || fail "no table of it"
# Where no row comes first by all four measures, the table says so.
for seed in 4 5; do paint "weak-$seed" --seed $seed --loss vanish --learning-rate 0.02 && measure "weak-$seed-measured" "weak-$seed"; done
expect_exit 0 "four rows" "$tabulate" --output four a=measured-1 b=third-measured c=weak-4-measured d=weak-5-measured
expected=$(awk -F , 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; split("effect effect_p_at_50 odds_ratio asr", names, " "); next }
  $3 == "adversarial" { ++rows; for (k = 1; k <= 4; k++) { value[rows, k] = $at[names[k]] + 0; if (rows == 1 || value[rows, k] > most[k]) most[k] = value[rows, k] } }
  END { for (row = 1; row <= rows; row++) { first = 0; for (k = 1; k <= 4; k++) first += value[row, k] == most[k]; if (first == 4) { print 0; exit } } print 1 }' four/table.csv)
[ "$(grep -c 'the measures rank different rows first' four/table.md)" = "$expected" ] && pass || fail "a contradiction: expected $expected of $(cat four/table.md)"

# Its figure has room for the names of rows, at 6 pixels a letter or more, and shows attention where that was measured.
name=a_row_whose_name_has_forty_letters_in_all
expect_exit 0 "a long name" "$tabulate" --output long $name=measured-1 other=third-measured
room=$(sed -nE "s/^<text x=\"([0-9.]+)\" .*>$name<.*/\1/p" long/table.svg)
awk -v room="$room" -v letters=${#name} 'BEGIN { exit !(room >= 6 * letters) }' && pass || fail "$room pixels for $name"
"$programs/evaluate" --run run-1 --protocol attention --quick --controls matched --output attentive >command.out 2>command.err || fail "attention: $(cat command.err)"
expect_exit 0 "attention" "$tabulate" --output seen row=attentive
share=$(awk -F , 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next } $3 == "adversarial" { print $at["attention"], $at["p_at_50"] }' seen/table.csv)
width=$(sed -nE 's/^<rect .* width="([0-9.]+)" height="9.*" class="second".*/\1/p' seen/table.svg)
awk -v share="$share" -v width="$width" 'BEGIN { split(share, of); exit !(of[1] != of[2] && (width - 270 * of[1]) ^ 2 < 1e-4) }' && pass || fail "a bar of $width, expected 270 of $share"
grep -q 'attention on the car' seen/table.svg && ! grep -q 'odds of being found' seen/table.svg && pass || fail "the figure does not say what it shows"

commit=$(sed -nE 's/^ *"commit": "([^"]*)",$/\1/p' run-1/manifest.json)
grep -q "Made by commit $commit\.$" all/table.md && pass || fail "the table does not say who made it: $(grep Made all/table.md)"
sed -i "s/\"commit\": \"$commit\"/\"commit\": \"another\"/" third/manifest.json
expect_exit 0 "a run by another commit" "$tabulate" --output all row=all-1,measured-2 other=third-measured
grep -q "Made by commits $commit, another\.$\|Made by commits another, $commit\.$" all/table.md && pass || fail "two commits: $(grep Made all/table.md)"
refused() { # WHAT PATTERN ROW...
  expect_refusal 4 "$2" "$1" "$tabulate" --output none "${@:3}"
  [ -e none ] && fail "$1: a refused table left a folder" || pass
}
sha='\(SHA-256 [0-9a-f]{16}\)'
refused "seeds at two confidences" 'row: measured-1 has confidence 0.25, surer has 0.01$' row=measured-1,surer
refused "rows at two confidences" 'row and other: measured-1 has confidence 0.25, surer has 0.01$' row=measured-1 other=surer
refused "seeds of two classes" 'row: measured-1 has class "car", van has "van"$' row=measured-1,van
refused "rows of two classes" 'has class "car", van has "van"$' row=measured-1 other=van
refused "seeds of two detectors of one name" "row: both-1 read second.onnx $sha, both-2 read second.onnx $sha\$" row=both-1,both-2
refused "rows of two detectors of one name" "row and other: both-1 read second.onnx $sha, both-2 read second.onnx $sha\$" \
  row=both-1 other=both-2
grep -q "$(sha256sum <second.onnx | cut -c 1-16)" command.err && pass || fail "another hash: $(cat command.err)"
refused "seeds in other frames" "row: measured-1 read frames/001.npz $sha, elsewhere read others/001.npz $sha\$" row=measured-1,elsewhere
refused "rows in other frames" "row and other: measured-1 read frames/001.npz $sha, elsewhere read others/001.npz $sha\$" row=measured-1 other=elsewhere
refused "seeds with other draws" 'few and measured-1 were not measured in the same frames with the same draws' row=measured-1,few
refused "one camouflage as two seeds" 'row: measured-1 and copied measured one camouflage, not two of its seeds' row=measured-1,copied

# Equal paints are one seed, whatever their runs say; a paint of another run than the one that is named is refused.
cp -r run-1 twin && sed -i 's/^  "seed": 1,$/  "seed": 7,/' twin/manifest.json
measure twin-measured twin
refused "a paint under two seeds" 'row: measured-1 and twin-measured measured one camouflage, not two of its seeds' row=measured-1,twin-measured
sed -i "s/\"texture.npz\": \"[0-9a-f]*\"/\"texture.npz\": \"$(sha256sum <run-2/texture.npz | cut -d ' ' -f 1)\"/" twin/manifest.json
refused "the paint of another run" "twin-measured/settings.json: measured a twin/texture.npz that is not of twin; expected SHA-256 $(
  sha256sum <run-2/texture.npz | cut -c 1-16).*, found SHA-256 $(sha256sum <run-1/texture.npz | cut -c 1-16)" row=twin-measured

# The same bytes under other names are the same.
mkdir elsewhere-frames && cp frames/000.npz elsewhere-frames/000.npz && cp frames/001.npz elsewhere-frames/002.npz
mkdir moved && cp detector.{cfg,weights,names} moved
measure same run-2 --frames elsewhere-frames --cfg moved/detector.cfg --weights moved/detector.weights --names moved/detector.names --size 64
expect_exit 0 "the same bytes under other names" "$tabulate" --output tables row=measured-1,same

# A run against another detector of the same name, both measured by one.
cp detector.weights kept && cp other.weights detector.weights
paint run-3 --seed 3
cp kept detector.weights
mkdir own && cp kept own/detector.weights
for run in 1 3; do measure "by-own-$run" "run-$run" --cfg detector.cfg --weights own/detector.weights --names detector.names --accept-changed-inputs; done
refused "seeds against two detectors of one name" "row: by-own-1 read detector.weights $sha, by-own-3 read detector.weights $sha\$" row=by-own-1,by-own-3
expect_exit 0 "a row of its own" "$tabulate" --output tables row=by-own-1 other=by-own-3

# A folder that is given twice, by whatever name.
ln -s measured-1 link
for twice in measured-1 ./measured-1/ "$PWD/measured-1" link others/../measured-1; do
  expect_refusal 2 'a folder is given twice: .*measured-1' "$twice as a second seed" "$tabulate" --output none "row=measured-1,$twice"
  expect_exit 2 "$twice as a second row" "$tabulate" --output none row=measured-1 "other=$twice"
done

# Measurements of versions whose ledgers state no roles.
cp -r measured-2 old && sed -i 's/"read_as"/"read"/' old/settings.json
expect_refusal 3 'old/settings.json: its ledger does not tell what was read as .*; measure it again' "a ledger without roles" "$tabulate" --output none row=old
finish
