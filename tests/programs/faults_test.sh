#!/usr/bin/env bash
# Fails the n-th system call of a kind for every n until the program makes no n-th call: the old file or the new one is
# there afterwards, as the exit status states; no temporary is left, and the next run succeeds.
source "$(dirname "$0")/support.sh"
source "$(dirname "$0")/faults.sh"
needs convert_weights camouflage make_dataset
[ -e "$shim" ] || exit 77

# A conversion over an old file.
inputs=(--cfg "$assets/detector.cfg" --weights "$assets/detector.weights")
"$convert_weights" "${inputs[@]}" --output old.onnx >/dev/null
"$convert_weights" "${inputs[@]}" --fold --output new.onnx >/dev/null
prepare() { cp old.onnx out.onnx; }
check_conversion() {
  if [ "$code" -eq 0 ]; then expect_same new.onnx out.onnx; elif cmp -s old.onnx out.onnx || cmp -s new.onnx out.onnx; then pass; else fail "a torn file"; fi
}
conversion=("$convert_weights" "${inputs[@]}" --fold --output out.onnx)
for call in write fsync rename; do until_success "$call" $ENOSPC "5" check_conversion "${conversion[@]}"; done # F04
until_success create $EROFS "5" check_conversion "${conversion[@]}" # F08
until_success open $EIO "0 3 5" check_conversion "${conversion[@]}"
until_success pread $EIO "3" check_conversion "${conversion[@]}"
for call in open write fsync pread; do until_success "$call" $EINTR "0" check_conversion "${conversion[@]}"; done # F07
until_success write short "0" check_conversion "${conversion[@]}"
until_success allocation $ENOMEM "0 8" check_conversion "${conversion[@]}" # F19

# A run: the same command, or --resume once there is a manifest, reaches the same bits.
mkdir frames && cp "$assets/frames/test/000.npz" frames
paint=("$camouflage" --frames frames --texels 4 --size 64 --epochs 2 --batch 1 --checkpoint-steps 1 --threads 1)
"${paint[@]}" --output expected >/dev/null 2>&1 || fail "an undisturbed run"
prepare() { rm -rf run; }
check_run() {
  local resume=()
  if [ "$code" -eq 0 ]; then
    expect_same expected/texture.npz run/texture.npz
    return
  fi
  if [ -e run/manifest.json ]; then resume=(--resume); fi
  "${paint[@]}" --output run "${resume[@]}" >/dev/null 2>again.err || fail "cannot go on: $(cat again.err)"
  expect_same expected/texture.npz run/texture.npz
}
for call in write fsync rename; do until_success "$call" $ENOSPC "0 5" check_run "${paint[@]}" --output run; done
until_success unlink $EIO "0 5" check_run "${paint[@]}" --output run
until_success stat $EIO "0 3 5" check_run "${paint[@]}" --output run
until_success pread $EIO "3" check_run "${paint[@]}" --output run
until_success open $EIO "0 3 5" check_run "${paint[@]}" --output run
until_success create $EROFS "5" check_run "${paint[@]}" --output run
until_success allocation $ENOMEM "0 8" check_run "${paint[@]}" --output run

# Frames of a car with a material file: if looking for that file fails, no other car is drawn.
cp "$assets"/car_sedan.{obj,mtl} .
draw=("$programs/make_dataset" --mesh car_sedan.obj --material body --train 1 --test 1 --size 32)
"${draw[@]}" --output drawn >/dev/null 2>&1 || fail "undisturbed frames"
check_frames() {
  local part
  for part in train test; do
    if [ "$code" -ne 0 ] && [ ! -e run/$part/0000.npz ]; then pass; else expect_same drawn/$part/0000.npz run/$part/0000.npz; fi
  done
}
for errno in $EIO $EACCES; do until_success stat "$errno" "0 3 5" check_frames "${draw[@]}" --output run; done
finish
