#!/usr/bin/env bash
# The scripts of examples/experiments from the outside: every table of the paper from one command, and variants.
source "$(dirname "$0")/support.sh"
experiments=$sources/examples/experiments
[ "$programs" = "$sources/build/release/examples" ] && [ -x "$programs/tabulate" ] || exit 77
mkdir -p own/train own/test
cp "$assets"/frames/test/00[0-3].npz own/test
cp "$assets"/frames/test/01[0-7].npz own/train
expect_exit 0 "a second detector" "$programs/convert_weights" --cfg "$assets/detector.cfg" --weights "$assets/detector.weights" \
  --output second.onnx
export COMMON="--batch 2 --size 128 --mesh $assets/car_sedan.obj --material body --names $assets/detector.names"
export FRAMES=$PWD/own FURTHER=$PWD/second.onnx EPOCHS=1 SEEDS=1 DRAWS=2 COARSE="--conditions camera"

# paper_in FOLDER ARGUMENTS...: the command in a folder of its own, so that the paths in its files are the same.
paper_in() { (mkdir -p "$1" && cd "$1" && bash "$experiments/paper.sh" out "${@:2}"); }
expect_exit 0 "every table" paper_in whole --quick
for table in 1-methods 2-physical 3-views 4-occlusion 6-losses 7-starts 8-resolution 9-attention; do
  for kind in csv json md tex svg; do expect_file "whole/out/tables/$table.$kind"; done
  grep -q "id=\"$table\"" whole/out/tables/index.html && pass || fail "the page has no $table"
done
tables=whole/out/tables
for name in fca mesh_adv camou upc das das_full coarse rauca planar_patch noise solid; do
  [ "$(grep -cE "^$name,(detector|second),(adversarial|matched noise)," $tables/1-methods.csv)" = 4 ] && pass || fail "$name in table 1"
done
grep -q '^| fca | [0-9.]* \[[0-9.]*, [0-9.]*\] | [0-9.]* \[[0-9.]*, [0-9.]*\] |$' $tables/1-methods.md && pass || fail "$(head -n 12 $tables/1-methods.md)"
grep -q '^fca & .* \\\\$' $tables/1-methods.tex && grep -q 'toprule' $tables/1-methods.tex && grep -q 'found, \\% (P@0.5)' $tables/1-methods.tex &&
  pass || fail "$(head -n 9 $tables/1-methods.tex)"
# The kept share is written if an effect differs from none: a matter of luck in runs as short as these.
kept=$(awk -F , 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next } $at["kept"] != "" { n++ } END { print n + 0 }' $tables/2-physical.csv)
[ "$(grep -c 'effect kept when photographed' $tables/2-physical.md)" = "$((kept > 0))" ] && pass || fail "a table of the share that is kept"
grep -q '^| fca | [0-9.]* | [0-9.]* |$' $tables/9-attention.md && pass || fail "no attention"
[ "$(grep -cE '^(8|16|32|64|128),detector,adversarial,1,' $tables/8-resolution.csv)" = 5 ] && pass || fail "the rows of resolutions"
# The two files hold the same detector: each figure twice.
for table in 1-methods 3-views; do
  awk -F , '$2 != "detector"' $tables/$table.csv | sed 's/,second,/,detector,/' >second.csv
  awk -F , '$2 != "second"' $tables/$table.csv >first.csv
  expect_same first.csv second.csv
done
# Links lead somewhere.
(cd $tables && grep -oE '(href|src)="[^"#:]*"' index.html | sed 's/^[^"]*"//;s/"$//' | sort -u |
  while read -r path; do [ -e "$path" ] || echo "no $path"; done) >lost.txt
[ ! -s lost.txt ] && pass || fail "links that lead nowhere: $(head -n 3 lost.txt)"

# A row has its measurement's figures.
awk -F , 'NR == FNR { if ($2 == "detector" && $3 == "adversarial") { found = $7; sure = $11 } next }
  $1 == "fca" && $2 == "detector" && $3 == "adversarial" { exit !($7 == found && $11 == sure) }' \
  whole/out/measured/digital-fca-1/digital.csv $tables/1-methods.csv && pass || fail "other figures than those measured"
grep -q '"draws": 2' whole/out/measured/digital-fca-1/digital.json && pass || fail "not two draws of noise"
effect=$(sed -nE 's/.*"difference": ([-0-9.e]+),$/\1/p' whole/out/measured/digital-fca-1/digital.json | head -n 1)
awk -F , -v effect="$effect" 'NR == 1 { while ($(++at) != "effect") {} }
  $1 == "fca" && $2 == "detector" && $3 == "adversarial" { exit ($at - effect) ^ 2 > 1e-15 }' $tables/1-methods.csv &&
  pass || fail "the effect is not $effect"

# Hard examples: those with a found car, and as many others, if there are any.
if [ -e whole/out/tables/5-hard.csv ]; then
  found=$(grep -c '^detector,adversarial,1,' whole/out/measured/digital-fca-1-train/photographs.csv)
  [ "$(ls whole/out/frames-hard_detector-1/train | wc -l)" = "$found" ] && pass || fail "not the frames in which it is found"
  cmp -s whole/out/runs/hard_detector-1/texture.npz whole/out/runs/fca-1/texture.npz && fail "nothing was optimised further" || pass
else
  grep -q 'no row in table 5' command.out && pass || fail "neither hard examples nor a word why not"
fi

# Killed again and again, and with one thread: the same files.
[ "${TAPESTRY_TESTS_LONG:-}" = ON ] && kills=10 again="1-methods 8-resolution" || { kills=3; again=8-resolution; }
numbers=$(sed 's/-[a-z]*//g' <<<"$again")
for ((kill = 1; kill <= kills; ++kill)); do
  LAUNCH="timeout -s KILL $((kill % 3 + 1))" paper_in killed --quick --tables "$numbers" >/dev/null 2>&1 || true
done
LAUNCH="taskset -c 0" expect_exit 0 "after kills" paper_in killed --quick --tables "$numbers"
for table in $again; do
  for kind in csv md tex svg json; do
    grep -v 'paper.sh' "$tables/$table.$kind" >whole.part
    grep -v 'paper.sh' "killed/out/tables/$table.$kind" >killed.part
    expect_same whole.part killed.part
  done
done
EPOCHS=2 expect_exit 7 "another number of passes" paper_in whole --quick
expect_exit 2 "a table that there is not" paper_in whole --quick --tables 12
expect_exit 2 "too little said" bash "$experiments/paper.sh"

# Variants over two seeds.
expect_exit 0 "variants" env -u FURTHER SEEDS="1 2" PROTOCOL=digital bash "$experiments/variants.sh" variants "$COMMON --frames own --epochs 1" \
  first= second="--loss vanish"
[ "$(grep -cE '^(first|second),detector,adversarial,2,1,8,' variants/tables/variants.csv)" = 2 ] && pass || fail "$(cat variants/tables/variants.csv)"
grep -q 'mean best confidence of first minus' variants/tables/variants.md && pass || fail "no comparison with the first"
cp variants/tables/variants.md before.md
rm -r variants/measured/digital-second-2 variants/tables
expect_exit 0 "what was interrupted goes on" env -u FURTHER SEEDS="1 2" PROTOCOL=digital bash "$experiments/variants.sh" variants "$COMMON --frames own --epochs 1" \
  first= second="--loss vanish"
expect_same variants/tables/variants.md before.md
expect_exit 7 "the same table with other options" env -u FURTHER SEEDS="1 2" bash "$experiments/variants.sh" variants "$COMMON --frames own --epochs 2" first=
expect_exit 2 "too few words" bash "$experiments/variants.sh" none

# Every part of the page of experiments, from one command, and finished parts are not done again: with --long.
cp second.onnx third.onnx && cp second.onnx fourth.onnx
page() { # [FOLDER]
  env -u COMMON -u FRAMES -u FURTHER BACKGROUNDS=places VIEW="--camera-height 2 --camera-pitch 8" CAR="--mesh $assets/car_sedan.obj --material body" NAMES="$assets/detector.names" SIZE=128 \
    bash "$experiments/page.sh" "${1:-page}" --quick second.onnx third.onnx fourth.onnx
}
PARTS=hardened expect_exit 2 "an attack before the search for its options" page early
expect_error_line 'part tables comes first'
expect_exit 2 "a page for two detectors" bash "$experiments/page.sh" page second.onnx third.onnx
if [ "${TAPESTRY_TESTS_LONG:-}" = ON ]; then
  mkdir places
  for picture in one1 one2 one3 two1; do
    expect_exit 0 "a photograph" "$programs/render" --size 120 90 --azimuth "${picture: -1}0" --output "places/$picture.png"
  done
  expect_exit 0 "the page" page
  options_of() { grep -E '"(learning-rate|smoothness-weight)"' "$1/manifest.json"; }
  for run in stronger/runs/paper-1 hardened/optimised; do
    [ "$(options_of page/$run)" = "$(options_of page/paper/runs/fca-1)" ] && pass || fail "$run has not the options of fca"
  done
  # A paint of the tables is not made again: the search has all other options from the tables.
  [ page/stronger/runs/fca-1 -ef page/paper/runs/fca-1 ] && [ page/stronger/measured/digital-fca-1 -ef page/paper/measured/digital-fca-1 ] &&
    pass || fail "fca is made twice"
  settings_of() { sed '/"outputs": {/,/}/d' "$1/manifest.json"; }
  [ "$(diff <(settings_of page/paper/runs/fca-1) <(settings_of page/stronger/runs/paper-1) | grep '^[<>]')" = '<     "loss": "max_score",
>     "loss": "paper",' ] && pass || fail "paper differs from fca by more than the loss"
  for file in sound/third-sound.onnx paper/tables/8-resolution.csv stronger/tables/variants.csv hardened/none/metrics.json hardened/optimised/metrics.json \
    results/world.csv; do
    expect_file "page/$file"
  done
  for name in second-sound third-sound fourth-sound second third fourth; do
    [ "$(grep -cE "^(8|16|32|64|128),$name,adversarial," page/paper/tables/8-resolution.csv)" = 5 ] && pass || fail "$name in the table"
  done
  [ "$(grep -cE '^without_first,(second|third|fourth)(-sound)?,adversarial,' page/stronger/tables/variants.csv)" = 6 ] && pass || fail "a paint for others is not measured by all"
  [ "$(grep -cE '^(fca|without_(second|third|fourth)),(second|third|fourth),adversarial,4,' page/results/world.csv)" = 12 ] && pass || fail "$(cat page/results/world.csv)"
  grep -q '^blue,second-sound,blue,' page/paper/tables/8-resolution.csv && pass || fail "no plain colours in the table"
  find page -type f -exec sha256sum {} + | sort -k 2 >page.before
  expect_exit 0 "the page once more" page
  find page -type f -exec sha256sum {} + | sort -k 2 >page.after
  expect_same page.before page.after
fi

# tabulate itself.
measured=whole/out/measured
expect_exit 2 "a row without a name" "$programs/tabulate" --output none "=$measured/digital-fca-1"
expect_error_line '^error: a row without a name; expected NAME=FOLDER'
expect_refusal 3 'absent: no settings.json in it' "a folder that is none" "$programs/tabulate" --output none row=absent
expect_exit 4 "seeds in other frames" "$programs/tabulate" --output none "row=$measured/digital-fca-1,$measured/digital-fca-1-train"
expect_error_line 'row: .*digital-fca-1 read .*, .*digital-fca-1-train read .*'
expect_exit 4 "rows in other frames" "$programs/tabulate" --output none "row=$measured/digital-fca-1" "other=$measured/digital-fca-1-train"
expect_error_line 'row and other: .*digital-fca-1 read .*, .*digital-fca-1-train read .*'
expect_exit 0 "the plain car" "$programs/evaluate" --protocol digital --clean-only --quick --frames own --size 128 --output plain
expect_exit 4 "a measurement without a camouflage" "$programs/tabulate" --output none row=plain
cp -r $measured/digital-fca-1 torn
printf '{"program": "evaluate"}' >torn/settings.json
expect_refusal 3 'torn/settings.json: no options of a measurement' "settings that are none" "$programs/tabulate" --output none row=torn
[ -e none ] && fail "a refused table left a folder behind" || pass

# A texture to begin with.
start=(--frames own --batch 2 --size 128)
expect_exit 3 "none there" "$programs/camouflage" "${start[@]}" --start none.npz --output none
expect_exit 2 "no first texture of that name" "$programs/camouflage" "${start[@]}" --start none --output none
expect_error_line "--start is 'none'; expected one of random, zero, own"
expect_exit 4 "that of another car" "$programs/camouflage" --texels 8 "${start[@]}" --start whole/out/runs/fca-1/texture.npz --output none
expect_error_line 'texture.npz: the texture is laid on a car in another way'
finish
