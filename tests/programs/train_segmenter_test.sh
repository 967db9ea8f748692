#!/usr/bin/env bash
# train_segmenter from the outside, and --mask u2net of the programs that read its files.
source "$(dirname "$0")/support.sh"
train=$programs/train_segmenter
[ -x "$train" ] || exit 77
small="--batch 2 --side 32 --validate 2"

expect_repeatable_training onnx "mean IoU"
expect_exit 0 "going on" "$train" $small --steps 2 --weights one.onnx --output further.onnx
cmp -s one.onnx further.onnx && fail "two steps changed nothing" || pass

expect_refusal 2 'did you mean --steps' "a misspelt option" "$train" --stepz 3
expect_senseless "$train --output refused.onnx" "--steps -3" "--learning-rate nan" "--threads 1000000" "--validate 1000000000000" "--batch 0" "--side 40"
[ -e refused.onnx ] && fail "a refused run wrote weights" || pass
expect_refusal 3 'absent.onnx' "missing weights" "$train" --weights absent.onnx --steps 0
expect_refusal 5 'absent/x.onnx' "a missing folder" "$train" $small --output absent/x.onnx

camouflage=$programs/camouflage
if [ -x "$camouflage" ]; then
  expect_exit 0 "masks by the bundled network" "$camouflage" --frames "$sources/examples/assets/frames" --mask u2net --check
  expect_exit 0 "masks by one's own" "$camouflage" --frames "$sources/examples/assets/frames" --mask u2net \
    --segmenter one.onnx --check
  expect_refusal 2 '--segmenter needs --mask u2net' "a network without its rule" "$camouflage" --segmenter one.onnx --check
  expect_refusal 3 'absent.onnx' "a network that is missing" "$camouflage" --mask u2net --segmenter absent.onnx --check
  head -c 1000 one.onnx >cut.onnx
  expect_refusal 3 'cut.onnx' "a network that is cut" "$camouflage" --mask u2net --segmenter cut.onnx --check
fi
finish
