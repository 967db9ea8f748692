#!/usr/bin/env bash
# The benchmark "renderer" on a car of few faces, with ours alone.
source "$(dirname "$0")/support.sh"
built=$programs/../benchmarks
[ -x "$built/renderer" ] && [ -x "$built/renderer_tapestry" ] || exit 77
mkdir alone && cp "$built/renderer" "$built/renderer_tapestry" alone
renderer=(alone/renderer --mesh "$sources/examples/assets/car_sedan.obj" --distances 5 --sizes 48 --rounds 2
          --seconds 0.001 --output results --threads 1)

expect_exit 0 "all stages" "${renderer[@]}"
csv=results/renderer.csv
[ "$(head -n 1 $csv)" = "case,variant,threads,seconds,error,memory_mib,spread,version,commit,compiler,instruction_set,processor" ] && pass || fail "header: $(head -n 1 $csv)"
for row in "visibility d=5 48,1x1" "frame d=5 48,4x4" "texture-backward d=5 48,4x4-forward" "step d=5 48,8x8" \
  "step d=5 48,automatic" "step d=5 48,4x4-cached" "vertex-gradient d=5 48,boundary_integral-4x4" \
  "vertex-gradient d=5 48,interior_only-1x1" "vertex-gradient d=5 48,neural_mesh_renderer-2x2"; do
  grep -Eq "^$row,1(,[0-9][0-9.e+-]*){4},[0-9]" $csv && pass || fail "no numbers for $row"
done
grep -q "^frame d=5 48,peer:llvmpipe,1,,,,,[0-9]" $csv && pass || fail "a peer that was not built has a value"
grep -Eq "^frame d=5 48,4x4-working,1,,,[0-9.]+,,[0-9]" $csv && pass || fail "no working memory"

# Errors of gradients: of a face's colour, of positions by the integral, and by the inside of faces alone.
error_of() { awk -F, -v row="$1" '$1 "," $2 == row { print $5 }' $csv; }
is_below() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a != "" && a + 0 < b) }'; }
found=$(error_of 'step d=5 48,8x8')
is_below "$found" 0.3 && pass || fail "texture gradient: $found"
is_below "$found" "$(error_of 'step d=5 48,2x2')" && pass || fail "more samples are no better"
found=$(error_of 'vertex-gradient d=5 48,boundary_integral-4x4')
is_below "$found" 0.05 && pass || fail "vertex gradient: $found"
found=$(error_of 'vertex-gradient d=5 48,interior_only-4x4')
is_below 0.3 "$found" && pass || fail "interior alone: $found"
for figure in renderer renderer-gradients; do
  grep -q "<svg" results/$figure.svg && pass || fail "no figure $figure.svg"
done
grep -q "boundary 4x4" results/renderer-gradients.svg && pass || fail "a point is not named"
expect_exit 2 "no such case" "${renderer[@]}" --case nothing
finish
