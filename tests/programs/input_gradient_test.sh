#!/usr/bin/env bash
# input_gradient finds the car surely and saves a picture of the score's gradient.
set -eu
"$1/input_gradient" | tee score.out
awk '{ exit !($2 > 0.9) }' score.out
cp input_gradient.png bundled.png
[ "$(head -c 8 input_gradient.png | od -An -tx1 | tr -d ' ')" = 89504e470d0a1a0a ]
# An ONNX model and a picture of one's own go the same way.
"$1/../tests/programs/export_detector" .
"$1/input_gradient" yolox.onnx input_gradient.png | tee score.out
awk '{ exit !($2 > 0 && $2 < 1) }' score.out
! cmp -s input_gradient.png bundled.png
