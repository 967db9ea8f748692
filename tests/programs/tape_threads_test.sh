#!/usr/bin/env bash
# tape_threads gives the same bits on one thread and on two.
set -eu
expected='weight 5.9829, bias -1.1190
gradients of one and of all threads: the same bits'
diff <(echo "$expected") <(TAPESTRY_THREADS=2 "$1/tape_threads")
diff <(echo "$expected") <(TAPESTRY_THREADS=1 "$1/tape_threads")
