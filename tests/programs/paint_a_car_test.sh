#!/usr/bin/env bash
# paint_a_car paints until the detector believes less in the car than at the start.
set -eu
"$1/paint_a_car" | tee painted.out
awk '/^step/ { belief = $NF; if (NR == 1) first = belief } END { exit !(NR == 3 && first > 1 && belief < 0.8 * first) }' painted.out
