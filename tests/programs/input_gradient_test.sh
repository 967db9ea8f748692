#!/usr/bin/env bash
# input_gradient finds the car surely and saves a picture of what the score rests on.
set -eu
"$1/input_gradient" | tee score.out
awk '{ exit !($2 > 0.9) }' score.out
[ "$(head -c 8 input_gradient.png | od -An -tx1 | tr -d ' ')" = 89504e470d0a1a0a ]
