#!/usr/bin/env bash
# Fails the n-th system call of a kind for every n until the program makes no n-th call: what is there afterwards is the
# old file or the new one, the exit status says which, nothing is left behind, and the next run makes it good.
source "$(dirname "$0")/support.sh"
shim=$programs/../tests/programs/libfault_shim.so
convert=$programs/convert_weights
camouflage=$programs/camouflage
assets=$sources/examples/assets
[ -x "$convert" ] && [ -x "$camouflage" ] && [ -e "$shim" ] || exit 77
EIO=5 EINTR=4 ENOSPC=28

# with_fault CALL N ERRNO COMMAND...: runs a command, sets `code` and, when the fault came to pass, `has_failed`.
with_fault() {
  local fault=$1:$2:$3
  shift 3
  rm -f mark
  TAPESTRY_FAULT=$fault TAPESTRY_FAULT_MARK=$PWD/mark LD_PRELOAD=$shim "$@" >command.out 2>command.err
  code=$?
  has_failed=false
  if [ -e mark ]; then has_failed=true; fi
}
# until_success CALL ERRNO EXITS CHECK COMMAND...: one fault after the other; CHECK looks at what is there. EXITS are
# the exit statuses that may be; 0 is for faults that a program can do without.
until_success() {
  local call=$1 errno=$2 exits=$3 check=$4 n count=0 harmless=0
  shift 4
  for ((n = 1; n <= 400; ++n)); do
    prepare
    with_fault "$call" "$n" "$errno" "$@"
    "$has_failed" || break
    count=$((count + 1))
    if [ "$code" -eq 0 ]; then harmless=$((harmless + 1)); fi
    [[ " $exits " == *" $code "* ]] && pass || fail "$call $n fails with $errno: exit status $code: $(cat command.err)"
    if [ "$code" -ne 0 ]; then expect_error_line '.'; fi
    ls -A . run 2>/dev/null | grep -q '\.part[0-9]' && fail "$call $n fails with $errno: a temporary is left" || pass
    "$check" "$@"
  done
  "$has_failed" && fail "$call: no end after $count faults" || pass
  [ "$count" -gt 0 ] && pass || fail "$call: not one fault"
  [ "$code" -eq 0 ] && pass || fail "$call: no end, or $code without a fault: $(cat command.err)"
  echo "$call, errno $errno: $count faults, $harmless of them without harm"
}

# A conversion over an old file.
inputs=(--cfg "$assets/detector.cfg" --weights "$assets/detector.weights")
"$convert" "${inputs[@]}" --output old >/dev/null
"$convert" "${inputs[@]}" --fold --output new >/dev/null
prepare() { cp old out; }
check_conversion() {
  if [ "$code" -eq 0 ]; then expect_same new out; elif cmp -s old out || cmp -s new out; then pass; else fail "a torn file"; fi
}
conversion=("$convert" "${inputs[@]}" --fold --output out)
for call in write fsync rename; do until_success "$call" $ENOSPC "5" check_conversion "${conversion[@]}"; done
until_success open $EIO "0 3 5" check_conversion "${conversion[@]}"
until_success pread $EIO "3" check_conversion "${conversion[@]}"
for call in open write fsync pread; do until_success "$call" $EINTR "0" check_conversion "${conversion[@]}"; done
until_success write short "0" check_conversion "${conversion[@]}"

# A run, which the same command, or --resume once there is a manifest, brings to the same bits.
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
until_success pread $EIO "3" check_run "${paint[@]}" --output run
until_success open $EIO "0 3 5" check_run "${paint[@]}" --output run
finish
