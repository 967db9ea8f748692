#!/usr/bin/env bash
# Outputs are locked: a second program is refused, and a signal that ends the first leaves no lock. Each is stopped in
# the middle of its work by the shim of faults_test.sh. (F30)
source "$(dirname "$0")/support.sh"
shim=$programs/../tests/programs/libfault_shim.so
[ -x "$programs/tabulate" ] && [ -x "$programs/train_segmenter" ] && [ -e "$assets/detector.weights" ] && [ -e "$shim" ] || exit 77

count=0
locks() { find . -name '.*lock'; }
is_stopped_or_over() {
  local state
  state=$(cut -d' ' -f3 "/proc/$1/stat" 2>/dev/null)
  [ "$state" = T ] || [ -z "$state" ]
}
# locked STATUS N PROGRAM OPTION...: stopped before the N-th file gets its name; STATUS is SIGTERM's, or any. OUT is
# replaced by a new name each time.
locked() {
  local status=$1 n=$2 program=$3 signal process code options=("${@:4}")
  for signal in TERM INT; do
    count=$((count + 1))
    set -- "${options[@]//OUT/out-$count}"
    TAPESTRY_FAULT=rename:$n:stop LD_PRELOAD=$shim "$programs/$program" "$@" >/dev/null 2>stopped.err &
    process=$!
    wait_for 120 is_stopped_or_over "$process"
    [ -n "$(locks)" ] && pass || fail "$program holds no lock: $(cat stopped.err)"
    expect_refusal 7 "is in use by process $process on " "$program, twice" "$programs/$program" "$@"
    kill "-$signal" "$process"
    kill -CONT "$process"
    code=147 # of a process that has stopped, which is told first
    while [ "$code" = 147 ]; do
      wait "$process" 2>/dev/null
      code=$?
    done
    [ "$status" = any ] || [ "$code" = $((128 + $(kill -l $signal))) ] && pass || fail "$program ends with $code by $signal"
    [ -z "$(locks)" ] && pass || fail "$program leaves $(locks) by $signal"
  done
}
mkdir frames && cp "$assets"/frames/test/00[01].npz frames
small=(--frames frames --texels 4 --size 64)
run() { "$programs/camouflage" "${small[@]}" --epochs 1 --threads 1 "$@" >/dev/null 2>&1 || fail "a run"; }
run --output run
"$programs/evaluate" --run run --protocol digital --quick --controls matched --output measured >/dev/null 2>&1 || fail "a measurement"
detector=(--cfg "$assets/detector.cfg" --weights "$assets/detector.weights")
"$programs/detect" --confidence 1 --annotate drawn frames/000.npz >/dev/null 2>&1
mkdir pictures && mv drawn/*.png pictures/a.png && echo "0 0.5 0.5 0.25 0.25" >pictures/a.txt

locked 143 1 convert_weights "${detector[@]}" --output OUT.onnx
locked 143 1 render --size 64 --output OUT.png
locked 143 2 render --size 64 --output OUT.png --export OUT.obj
locked 143 1 render --size 64 --material body --texture run/texture.png --output OUT.png --panels OUT.pdf
locked 143 2 tabulate --output OUT row=measured
locked 143 3 make_dataset --train 1 --test 2 --size 64 --output OUT
locked 143 6 make_dataset --train 1 --test 2 --size 64 --output OUT
locked 143 3 make_assets --train 1 --test 1 --size 64 --output OUT
locked 143 2 detect --annotate OUT frames/000.npz frames/001.npz
locked 143 1 detect --sheet OUT.png frames/000.npz
locked 143 4 evaluate --dataset pictures --csv OUT.csv --json OUT.json --results OUT.results
locked 143 2 evaluate --clean-only --frames frames --output OUT
locked any 3 evaluate --run run --protocol digital --quick --controls matched --output OUT
locked any 2 camouflage "${small[@]}" --epochs 1 --output OUT
locked any 2 harden --frames frames --scenes 2 --texels 4 --attack-steps 1 --steps 1 --rounds 1 --pictures 2 --clean-scenes 2 --test-scenes 2 \
  --epochs 1 --output OUT
locked any 2 train_detector --cfg "$assets/detector.cfg" --batch 1 --fresh 1 --pool 1 --validate 1 --size 64 --steps 2 --save-every 1 --output OUT.weights
locked any 2 train_segmenter --side 32 --batch 2 --validate 2 --steps 2 --save-every 1 --output OUT.onnx
finish
