#!/usr/bin/env bash
# As faults_test.sh, of train_detector and evaluate: its protocols, its tables of a run, and data sets.
source "$(dirname "$0")/support.sh"
source "$(dirname "$0")/faults.sh"
needs train_detector evaluate
[ -e "$shim" ] || exit 77

# Training over an old file: the old file or a whole new one is there, and training can continue from it.
training=("$train_detector" --cfg "$assets/detector.cfg" --batch 1 --fresh 1 --pool 1 --validate 1 --size 64 --threads 1 --output out.weights)
"${training[@]}" --steps 1 --seed 7 >/dev/null 2>&1 || fail "another training"
mv out.weights old
twice=("${training[@]}" --steps 2 --save-every 1)
with_fault rename 3 $EIO "${twice[@]}" # behind that of a probe
mv out.weights first
"${twice[@]}" >/dev/null 2>&1 || fail "an undisturbed training"
cp out.weights second
cmp -s first second && fail "the second step is not that of the first" || pass
prepare() { cp old out.weights; }
check_training() {
  if [ "$code" -eq 0 ]; then
    expect_same second out.weights
    return
  fi
  cmp -s old out.weights || cmp -s first out.weights || cmp -s second out.weights && pass || fail "a torn file"
  [ "$call" = rename ] || return # each file that can be there was read then
  "${training[@]}" --weights out.weights --steps 1 >/dev/null 2>again.err && pass || fail "cannot go on: $(cat again.err)"
}
for call in write fsync rename; do until_success "$call" $ENOSPC "5" check_training "${twice[@]}"; done
until_success create $EROFS "5" check_training "${twice[@]}"
until_success open $EIO "0 3 5" check_training "${twice[@]}"
until_success pread $EIO "3" check_training "${twice[@]}" --weights old
for call in open write fsync; do until_success "$call" $EINTR "0" check_training "${twice[@]}"; done
until_success allocation $ENOMEM "0 8" check_training "${twice[@]}"

# A measurement, which the same command brings to the same files.
mkdir frames && cp "$assets/frames/test/000.npz" frames
measuring=("$evaluate" --protocol digital --clean-only --frames frames --threads 1)
"${measuring[@]}" --output expected >/dev/null 2>&1 || fail "an undisturbed measurement"
prepare() { rm -rf run; }
check_measurement() {
  local file
  if [ "$code" -ne 0 ]; then "${measuring[@]}" --output run >/dev/null 2>again.err || fail "cannot go on: $(cat again.err)"; fi
  for file in digital.{csv,json,md,svg,html} photographs.csv outcomes.npz settings.json; do expect_same expected/$file run/$file; done
}
for call in write fsync rename; do until_success "$call" $ENOSPC "5" check_measurement "${measuring[@]}" --output run; done
until_success create $EROFS "5" check_measurement "${measuring[@]}" --output run
until_success open $EIO "0 3 5" check_measurement "${measuring[@]}" --output run
until_success pread $EIO "3" check_measurement "${measuring[@]}" --output run
for call in write fsync pread; do until_success "$call" $EINTR "0" check_measurement "${measuring[@]}" --output run; done
until_success allocation $ENOMEM "0 8" check_measurement "${measuring[@]}" --output run

# The figures of the plain car and of a data set: files are whole or absent.
figures=("$evaluate" --clean-only --frames frames --threads 1)
"${figures[@]}" --output figures >/dev/null 2>&1 || fail "undisturbed figures"
check_figures() {
  local file
  for file in metrics.csv metrics.json clean.png; do
    if [ "$code" -ne 0 ] && [ ! -e run/$file ]; then pass; else expect_same figures/$file run/$file; fi
  done
}
for call in write rename; do until_success "$call" $ENOSPC "5" check_figures "${figures[@]}" --output run; done

"$programs/detect" --confidence 1 --annotate drawn frames/000.npz >/dev/null 2>&1
mkdir pictures && mv drawn/*.png pictures/a.png && echo "0 0.5 0.5 0.25 0.25" >pictures/a.txt
scoring=("$evaluate" --dataset pictures --threads 1 --csv run/a.csv --json run/a.json --results run/a.results)
rm -rf run && mkdir run && "${scoring[@]}" >/dev/null 2>&1 || fail "an undisturbed data set"
mv run scored
prepare() { rm -rf run && mkdir run; }
check_scores() {
  local file
  for file in a.csv a.json a.results; do
    if [ "$code" -ne 0 ] && [ ! -e run/$file ]; then pass; else expect_same scored/$file run/$file; fi
  done
}
for call in write fsync rename; do until_success "$call" $ENOSPC "5" check_scores "${scoring[@]}"; done
until_success pread $EIO "3" check_scores "${scoring[@]}"
until_success allocation $ENOMEM "0 8" check_scores "${scoring[@]}"
finish
