#!/usr/bin/env bash
# fit_shape finds the car's pose to half a degree and a centimetre, and bends the sphere to an IoU of 0.97.
set -eu
"$1/fit_shape" | tee output.txt
awk '/^pose:/ { posed = $9 <= 0.5 && $12 <= 1 } /^shape:/ { shaped = $8 >= 0.97 } END { exit !(posed && shaped) }' output.txt
