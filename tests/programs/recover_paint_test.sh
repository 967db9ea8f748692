#!/usr/bin/env bash
# recover_paint finds the four colours that the picture was painted with.
set -eu
expected='squared error of the picture below 1e-8
texel 0: 0.90 0.10 0.10
texel 1: 0.20 0.70 0.30
texel 2: 0.10 0.30 0.80
texel 3: 0.60 0.60 0.20'
diff <(echo "$expected") <("$1/recover_paint")
