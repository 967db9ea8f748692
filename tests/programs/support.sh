# Sourced by the program tests: counts checks and closes with a line of totals.
set -u
set -m  # without job control, scripts start background processes with SIGINT ignored, and so it would stay
programs=$1
sources=$2
failures=0
passes=0

pass() { passes=$((passes + 1)); }
fail() {
  failures=$((failures + 1))
  echo "FAILED: $*"
}
# expect_exit CODE WHAT COMMAND...: runs a command quietly and compares its exit code.
expect_exit() {
  local expected=$1 what=$2
  shift 2
  "$@" >command.out 2>command.err
  local code=$?
  if [ "$code" -eq "$expected" ]; then pass; else
    fail "$what: exit code $code, expected $expected"
    tail -n 5 command.out command.err
  fi
}
# expect_error_line PATTERN: the last command wrote exactly one line `error: …`, and it matches.
expect_error_line() {
  local count
  count=$(grep -c '^error: ' command.err)
  if [ "$count" -eq 1 ] && grep -Eq -- "$1" command.err; then pass; else
    fail "expected one error line matching '$1', got:"
    cat command.err
  fi
}
expect_same() {
  if cmp -s "$1" "$2"; then pass; else fail "$1 and $2 differ"; fi
}
expect_file() {
  if [ -s "$1" ]; then pass; else fail "$1 is missing or empty"; fi
}
finish() {
  echo "$passes passed, $failures failed"
  [ "$failures" -eq 0 ]
}
