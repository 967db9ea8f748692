#!/usr/bin/env bash
# Variants of an optimisation from the outside: the tables of losses, of first textures, of methods and of physical conditions.
source "$(dirname "$0")/support.sh"
experiments=$sources/examples/experiments
[ "$programs" = "$sources/build/release/examples" ] && [ -x "$programs/evaluate" ] || exit 77
mkdir -p own/train own/test
cp "$sources"/examples/assets/frames/test/00[0-3].npz own/test
cp "$sources"/examples/assets/frames/test/01[0-7].npz own/train
common="--frames own --epochs 2 --batch 2 --texels 16 --size 128 --mesh $sources/examples/assets/car_sedan.obj --material body"
export SEEDS="1 2"
number='-?[0-9]+\.[0-9]{3}'
for_seed="\| [0-9.]+ % \| [0-9]+ \| [0-9]+ \| $number \| $number \| $number \[$number, $number\] \| $number \[$number, $number\] \|"
for_all="\| \| \| \| $number \($number to $number\) \| $number \($number to $number\) \| $number \($number to $number\) \| $number \($number to $number\) \|"

expect_exit 0 "losses" bash "$experiments/losses.sh" losses "$common"
expect_file losses/variants.md
for name in paper as_coded vanish max_score; do
  [ "$(grep -cE "^\| $name \| [12] $for_seed$" losses/variants.md)" = 2 ] && pass || fail "$name: $(cat losses/variants.md)"
  [ "$(grep -cE "^\| $name \| all $for_all$" losses/variants.md)" = 1 ] && pass || fail "all of $name: $(cat losses/variants.md)"
done
[ "$(grep -cE '^\| paper .* 0\.000 \[0\.000, 0\.000\] \|$' losses/variants.md)" = 2 ] && pass || fail "a loss differs from itself"
printed=$(sed -n 's/.*beyond other run: mean best confidence \([^,]*, [^]]*\]\).*/\1/p' losses/measured-max_score-1/printed.txt)
grep -Fq "| $printed |" losses/variants.md && [ "${printed%% *}" != 0.000 ] && pass || fail "not what was measured: $printed"
cp losses/variants.md before.md
rm -r losses/measured-as_coded-2 losses/variants.md
expect_exit 0 "what was interrupted goes on" bash "$experiments/losses.sh" losses "$common"
expect_same losses/variants.md before.md

expect_exit 7 "the same table with other options" bash "$experiments/losses.sh" losses "$common --learning-rate 0.05"
export SEEDS=1
expect_exit 0 "first textures" bash "$experiments/initialisation.sh" starts "$common"
[ "$(grep -cE '^\| (random|zero|own) \| 1 ' starts/variants.md)" = 3 ] && pass || fail "the rows of first textures"
ROWS="8 16" expect_exit 0 "resolutions" bash "$experiments/resolution.sh" rows "${common/--texels 16 /}"
[ "$(grep -cE '^\| (8|16) \| 1 \| .* - \|$' rows/variants.md)" = 2 ] && pass || fail "the rows of resolutions: $(cat rows/variants.md)"
expect_exit 0 "methods" bash "$experiments/methods.sh" methods "$common"
for name in fca planar_patch camou upc das das_full rauca mesh_adv random solid; do
  [ "$(grep -cE "^\| $name \| 1 $for_seed$" methods/variants.md)" = 1 ] && pass || fail "$name: $(cat methods/variants.md)"
done
grep -q '"light"' methods/measured-rauca-1/metrics.json && fail "rauca was measured in another light than the others" || pass
DRAWS=2 PROTOCOL="--quick --controls matched" expect_exit 0 "physical conditions" bash "$experiments/physical.sh" physical "$common"
grep -q '"draws": 2' physical/measured-physical-1/metrics.json && pass || fail "not measured under conditions"
[ "$(grep -cE '^protocol-(as_they_are|physical)-1: .*(effect kept|not defined).*physical.md$' command.out)" = 2 ] && pass || fail "no word on what is kept"
expect_file physical/protocol-physical-1/physical.csv
expect_exit 2 "too little said" bash "$experiments/variants.sh" none
expect_exit 2 "no folder" bash "$experiments/losses.sh"
finish
