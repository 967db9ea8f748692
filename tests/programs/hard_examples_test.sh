#!/usr/bin/env bash
# The table of hard examples from the outside.
source "$(dirname "$0")/support.sh"
hard_examples=$sources/examples/experiments/hard_examples.sh
assets=$sources/examples/assets
[ "$programs" = "$sources/build/release/examples" ] && [ -x "$programs/evaluate" ] || exit 77
mkdir -p own/train own/test
cp "$assets"/frames/test/00[0-3].npz own/test
cp "$assets"/frames/test/01[0-7].npz own/train
common="--batch 2 --texels 16 --size 128 --mesh $assets/car_sedan.obj --material body"
expect_exit 0 "a camouflage" "$programs/camouflage" $common --frames own --epochs 1 --output run
table() { EPOCHS=1 bash "$hard_examples" table run "$common"; }
expect_exit 0 "hard examples" table
row='[0-8]/8 \(0\.[0-9]{3}\) \| [0-4]/4 \(0\.[0-9]{3}\) \| [0-4]/4 \(0\.[0-9]{3}\) \| [0-4]/4 \(0\.[0-9]{3}\)'
[ "$(grep -cE "^\| detector \| $row \|$" table/hard_examples.md)" = 1 ] && pass || fail "the table is $(cat table/hard_examples.md)"
found=$(sed -nE 's/^\| detector \| ([0-9]+)\/8.*/\1/p' table/hard_examples.md)
[ "$(ls table/hard/train | wc -l)" = "$found" ] && [ "$(ls table/chance/train | wc -l)" = "$found" ] && pass || fail "not the frames in which it is found"
cmp -s table/run-hard/texture.npz run/texture.npz && fail "nothing was optimised further" || pass
grep -q '"start": "run/texture.npz"' table/run-hard/manifest.json && pass || fail "it did not begin with the run's texture"
cp table/hard_examples.md before.md
rm -r table/after-hard table/hard_examples.md
expect_exit 0 "what was interrupted goes on" table
expect_same table/hard_examples.md before.md
expect_exit 7 "another number of passes" env EPOCHS=2 bash "$hard_examples" table run "$common"
expect_exit 2 "frames twice" bash "$hard_examples" other run "--frames own $common"
expect_exit 3 "no run" bash "$hard_examples" none own "$common"
expect_exit 0 "a camouflage of frames that are not divided" "$programs/camouflage" $common --frames own/test --epochs 1 --output whole
expect_exit 4 "a run without a folder of training" bash "$hard_examples" none whole "$common"
expect_exit 2 "too little said" bash "$hard_examples" none

# A texture to begin with.
expect_exit 3 "none there" "$programs/camouflage" $common --frames own --start none.npz --output none
expect_exit 2 "no first texture of that name" "$programs/camouflage" $common --frames own --start none --output none
expect_error_line "--start is 'none'; expected one of random, zero, own"
expect_exit 4 "that of another car" "$programs/camouflage" --texels 8 --frames own --start run/texture.npz --output none
expect_error_line 'run/texture.npz: the texture does not fit the car'
finish
