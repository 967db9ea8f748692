#!/usr/bin/env bash
# fit_curve finds the curve of its points, 2·exp(−0.75·t) + 0.5, within their noise.
set -eu
expected='y = 1.9933 exp(-0.7492 t) + 0.5011
squared error 0.000867, gradient zero'
diff <(echo "$expected") <("$1/fit_curve")
