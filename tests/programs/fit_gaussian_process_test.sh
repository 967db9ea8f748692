#!/usr/bin/env bash
# fit_gaussian_process finds the noise of 0.1 in its measurements of a sine, whose length is a few units.
set -eu
diff <(printf 'two records for two decompositions: yes\nnoise 0.11, length 2.0\n') <("$1/fit_gaussian_process")
