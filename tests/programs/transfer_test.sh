#!/usr/bin/env bash
# The matrix of transfer from the outside.
source "$(dirname "$0")/support.sh"
transfer=$sources/examples/experiments/transfer.sh
assets=$sources/examples/assets
[ "$programs" = "$sources/build/release/examples" ] && [ -x "$programs/make_dataset" ] || exit 77
export TRAIN=8 TEST=4 SIZE=128 EPOCHS=1 TEXELS=16

bundled="--cfg $assets/detector.cfg --weights $assets/detector.weights --names $assets/detector.names"
matrix() { bash "$transfer" matrix "--mesh $assets/car_sedan.obj --material body" 0 first="$bundled" second="$bundled"; }
expect_exit 0 "two detectors" matrix
expect_file matrix/transfer.md
cp matrix/transfer.md before.md
[ "$(grep -cE '^\| (first|second) \| (first|second) \| frames \| [0-4]/4 \(0\.[0-9]{3}\) .* \| -?[0-9.]+ \[-?[0-9.]+, -?[0-9.]+\] \|$' before.md)" = 4 ] &&
  pass || fail "the table is $(cat before.md)"
rm -r matrix/first-second-0 matrix/transfer.md
expect_exit 0 "what was interrupted goes on" matrix
expect_same matrix/transfer.md before.md
mkdir own
cp "$assets"/frames/test/00[0-3].npz own
FRAMES=own expect_exit 0 "frames of our own, too" matrix
[ "$(grep -c '^| .* | own | ' matrix/transfer.md)" = 4 ] && pass || fail "no rows of the other frames"
expect_exit 2 "too little said" bash "$transfer" matrix
finish
