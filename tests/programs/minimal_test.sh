#!/usr/bin/env bash
# minimal prints the loss w²·5 + e^(−w)·34 at w = 1/2 for the triangle (0,0) (3,0) (3,4), and its gradient.
set -eu
expected='loss 21.872042, by weight -15.622042
by corner 0: -0.150000 -0.200000
by corner 1: 3.639184 0.000000
by corner 2: 3.789184 5.052245'
diff <(echo "$expected") <("$1/minimal")
