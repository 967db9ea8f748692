#!/usr/bin/env bash
# benchmark_names_test.sh: every benchmark that a page names is one that benchmarks/run.sh lists, and run.sh refuses others.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
listed=$(benchmarks/run.sh | sed -nE 's/^  ([a-z_]+):.*/\1/p')
named=$(grep -ohE 'benchmarks/run\.sh [a-z_]+|`[a-z_]+_bench`' README.md CHANGELOG.md benchmarks/README.md docs/*.md |
  sed -E 's/.* //; s/`//g' | sort -u)
[ "$(wc -w <<<"$named")" -ge 10 ] || { echo "few names are found on pages: $named"; exit 1; }
for name in $named; do
  grep -qx "$name" <<<"$listed" || { echo "a page names the benchmark $name, which run.sh does not know"; exit 1; }
done
if benchmarks/run.sh no_such_bench >/dev/null 2>&1; then echo "run.sh runs what is not there"; exit 1; fi
[[ $(benchmarks/run.sh no_such_bench 2>&1 || true) == *"no benchmark 'no_such_bench'"* ]]
