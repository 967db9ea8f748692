#!/usr/bin/env bash
# Physical conditions from the outside: camouflage and evaluate under them, and one run against another.
source "$(dirname "$0")/support.sh"
needs camouflage evaluate
quick=(--scenes 24 --texels 32 --epochs 2 --checkpoint-steps 1 --size 128 --conditions physical)

expect_exit 0 "a run under conditions" "$camouflage" "${quick[@]}" --threads 2 --output two
grep -q '"conditions": *\[' two/manifest.json && pass || fail "the manifest does not name the conditions"
expect_exit 0 "the same with one thread" "$camouflage" "${quick[@]}" --threads 1 --output one
expect_same one/texture.npz two/texture.npz
expect_exit 0 "without conditions" "$camouflage" --scenes 24 --texels 32 --epochs 2 --size 128 --output plain
if cmp -s plain/texture.npz two/texture.npz; then fail "conditions change nothing"; else pass; fi
grep -q '"conditions"' plain/manifest.json && fail "a manifest names conditions that are not there" || pass

# If a method paints parts, only these are printed and counted as printable; of a clean car nothing is.
expect_exit 0 "parts, printed" "$camouflage" "${quick[@]}" --method das --printability 5 --output parts
expect_exit 0 "parts measured" "$evaluate" --run parts --output parts_plain
expect_exit 0 "parts measured in print" "$evaluate" --run parts --conditions print --draws 1 --output parts_printed
expect_same <(grep '^clean,' parts_plain/metrics.csv) <(grep '^clean,' parts_printed/metrics.csv)
[ "$(grep '^matched noise,' parts_plain/metrics.csv)" != "$(grep '^matched noise,' parts_printed/metrics.csv)" ] && pass ||
  fail "the matched noise is not printed"

# Killed on the way and resumed: the step's number decides the next draws.
kill_until_done killed 3 1 "$camouflage" "${quick[@]}"
expect_same killed/texture.npz two/texture.npz

expect_refusal 2 "'fog' is none of camera, light" "conditions that are not known" "$camouflage" --conditions blur fog --output none  # F28
expect_exit 7 "resumed under other conditions" "$camouflage" --resume --output two --conditions blur

# Measured under them: the same rows for the same seed and any number of threads.
under=(--run two --conditions physical --draws 3)
expect_exit 0 "measured under conditions" "$evaluate" "${under[@]}" --threads 2 --output under
expect_exit 0 "measured again, one thread" "$evaluate" "${under[@]}" --threads 1 --output under_again
expect_same under/metrics.csv under_again/metrics.csv
expect_exit 0 "measured as they are" "$evaluate" --run two --output as_they_are
if cmp -s under/metrics.csv as_they_are/metrics.csv; then fail "conditions change no figure"; else pass; fi
[ "$(sed -n 's/^clean,\([0-9]*\),.*/\1/p' under/metrics.csv)" = \
  $((3 * $(sed -n 's/^clean,\([0-9]*\),.*/\1/p' as_they_are/metrics.csv))) ] && pass || fail "not three pictures a view"
# Of 240 pictures a sheet shows 160, in 20 rows of 128 pixels and gaps of 4.
[ "$(od -An -tu1 -j 20 -N 4 under/adversarial.png | awk '{ print 65536 * $2 + 256 * $3 + $4 }')" = 2644 ] && pass ||
  fail "the sheet's height is $(od -An -tu1 -j 20 -N 4 under/adversarial.png)"
expect_exit 2 "conditions that are not known" "$evaluate" --run two --conditions fog
expect_exit 2 "draws of nothing" "$evaluate" --run two --draws 2
expect_exit 2 "a protocol under conditions" "$evaluate" --run two --protocol views --quick --conditions blur
expect_exit 2 "no draws" "$evaluate" --run two --conditions blur --draws 0

# Against another run; against itself nothing is left.
expect_exit 0 "against another run" "$evaluate" --run two --against plain
grep -q 'effect beyond other run: mean best confidence' command.out && pass || fail "no effect beyond the other run"
expect_exit 0 "against itself" "$evaluate" --run two --against two --output itself
grep -q 'effect beyond other run: mean best confidence 0.000 \[0.000, 0.000\]' command.out && pass || fail "a run differs from itself"
expect_exit 2 "nothing against a run" "$evaluate" --clean-only --against plain
expect_refusal 2 '--against has no part in --protocol' "a protocol against another run" "$evaluate" --run two --protocol views --quick --against plain
expect_exit 3 "a run that is not there" "$evaluate" --run two --against nowhere
finish
