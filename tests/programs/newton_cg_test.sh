#!/usr/bin/env bash
# newton_cg reaches the minimum of Rosenbrock's valley in 100 dimensions, which is at one.
set -eu
diff <(echo 'minimum reached, within 1e-9 of one everywhere') <("$1/newton_cg")
