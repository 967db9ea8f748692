#!/usr/bin/env bash
# The benchmark "readers": that no reader takes more memory than its comment states, and a row of its table.
source "$(dirname "$0")/support.sh"
readers=$programs/../benchmarks/readers
[ -x "$readers" ] || exit 77

expect_exit 0 "memory of every reader" "$readers" --check-memory
expect_exit 0 "one kind of file" "$readers" --case '^palette$' --rounds 1
expect_exit 0 "two kinds of files" "$readers" --case 'yolo|voc: entities' --rounds 1
finish
