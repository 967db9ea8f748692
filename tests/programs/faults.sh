# Sourced by the tests of faults, after support.sh: makes the n-th call of a kind fail, for every n until a program makes no
# n-th call, and checks the files that are left. See fault_shim.cpp for the calls.
shim=$programs/../tests/programs/libfault_shim.so
EIO=5 EINTR=4 EACCES=13 ENOMEM=12 ENOSPC=28 EROFS=30

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
# until_success CALL ERRNO EXITS CHECK COMMAND...: one fault after the other; CHECK tests the files there. EXITS are the
# exit statuses that may be; 0 is for faults that a program can do without. From the eighth on, n grows by half: of
# allocations, which are many, and without the rare tests of all calls.
until_success() {
  local call=$1 errno=$2 exits=$3 check=$4 n=0 count=0 harmless=0
  shift 4
  while [ "$count" -lt 400 ]; do
    if [ "$n" -gt 8 ] && { [ "$call" = allocation ] || [ "${TAPESTRY_TESTS_LONG:-}" != ON ]; }; then n=$((n + n / 2)); else n=$((n + 1)); fi
    prepare
    with_fault "$call" "$n" "$errno" "$@"
    "$has_failed" || break
    count=$((count + 1))
    if [ "$code" -eq 0 ]; then harmless=$((harmless + 1)); fi
    [[ " $exits " == *" $code "* ]] && pass || fail "$call $n fails with $errno: exit status $code: $(cat command.err)"
    if [ "$code" -ne 0 ]; then expect_error_line '.'; fi
    ls -A . run 2>/dev/null | grep -q '^\.tapestry-\|\.tapestry-part' && fail "$call $n fails with $errno: a temporary is left" || pass
    "$check" "$@"
  done
  "$has_failed" && fail "$call: no end after $count faults" || pass
  [ "$count" -gt 0 ] && pass || fail "$call: not one fault"
  [ "$code" -eq 0 ] && pass || fail "$call: no end, or $code without a fault: $(cat command.err)"
  echo "$call, errno $errno: $count faults, $harmless of them without harm"
}
