#!/usr/bin/env bash
# curvature finds the largest eigenvalues by products alone, and both ways of descent lower the loss.
set -eu
"$1/curvature" | tee found.out
awk 'NR == 1 { loss = $2 + 0; ok = $1 == "loss" && $5 > 0 && $5 > $6 && $6 >= $7 && $7 >= $8 && $8 >= $9 }
     NR == 2 { ok = ok && $9 + 0 < loss && $NF + 0 < loss }
     END { exit !(ok && NR == 2) }' found.out
