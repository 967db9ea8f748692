# Sourced by the program tests: counts checks and closes with a line of totals.
set -u
set -m  # without job control, scripts start background processes with SIGINT ignored, and so it would stay
programs=$1
sources=$2
assets=$sources/examples/assets
failures=0
passes=0

# needs PROGRAM...: sets a variable of each name to its path; skips the test where it or the bundled detector is missing.
needs() {
  local name
  for name; do
    printf -v "$name" %s "$programs/$name"
    [ -x "$programs/$name" ] && [ -e "$assets/detector.weights" ] || exit 77
  done
}
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
# expect_refusal CODE PATTERN WHAT COMMAND...: the two in one.
expect_refusal() {
  expect_exit "$1" "${@:3}"
  expect_error_line "$2"
}
expect_same() {
  if cmp -s "$1" "$2"; then pass; else fail "$1 and $2 differ"; fi
}
# expect_figures_of_run METRICS PROTOCOL: a protocol's CSV gives the bundled detector's counts and confidences of a run's CSV; only
# a protocol has picture noise.
expect_figures_of_run() {
  awk -F , 'NR == FNR { if (FNR > 1) { found[$1] = $3; sure[$1] = $7 } next }
      FNR > 1 && $2 == "detector" && $3 != "picture noise" { rows++
        if (!($3 in found) || found[$3] != $7 || (sure[$3] - $11) ^ 2 > 1e-12) exit 1 } END { exit rows != 12 }' "$1" "$2" && pass ||
    fail "$2 differs from $1"
}
expect_file() {
  if [ -s "$1" ]; then pass; else fail "$1 is missing or empty"; fi
}
# wait_for SECONDS COMMAND...: until the command succeeds, at most so long; the caller tests whether it did.
wait_for() {
  local tenths=$(($1 * 10))
  shift
  while [ "$tenths" -gt 0 ] && ! "$@"; do
    sleep 0.1
    tenths=$((tenths - 1))
  done
}
# kill_until_done FOLDER KILLS SECONDS COMMAND...: runs a command that works in a folder, kills it that often within so many
# seconds of its start, and resumes it until metrics.json is there.
kill_until_done() {
  local folder=$1 most=$2 seconds=$3 kills=0 resume=() process code
  shift 3
  RANDOM=7
  mkdir -p "$folder"
  while [ ! -e "$folder/metrics.json" ] && [ "$kills" -lt 60 ]; do
    "$@" --output "$folder" "${resume[@]}" >/dev/null 2>killed.err &
    process=$!
    if [ "$kills" -lt "$most" ]; then
      sleep "$((RANDOM % seconds)).$((RANDOM % 9 + 1))"
      kill -KILL "$process" 2>/dev/null
      kills=$((kills + 1))
    fi
    wait "$process" 2>/dev/null
    code=$?
    if [ "$code" -ne 0 ] && [ "$code" -ne 137 ]; then
      fail "a run after a kill ended with $code"
      cat killed.err
      break
    fi
    if [ -e "$folder/manifest.json" ]; then resume=(--resume); fi
  done
  echo "killed $kills times"
}
# kill_until_measured FOLDER OPTION...: evaluate, killed three times some moment after it has saved something, and started
# again.
kill_until_measured() {
  local folder=$1 kills=0 code=137 process
  shift
  RANDOM=5
  while [ "$code" -eq 137 ] && [ "$kills" -lt 40 ]; do
    touch started
    "$programs/evaluate" "$@" --output "$folder" >/dev/null 2>killed.err &
    process=$!
    if [ "$kills" -lt 3 ]; then
      for _ in $(seq 3000); do
        [ "$folder/outcomes.npz" -nt started ] && break
        sleep 0.005
      done
      sleep "0.0$((RANDOM % 7 * kills))"
      kill -KILL "$process" 2>/dev/null
    fi
    wait "$process" 2>/dev/null
    code=$?
    [ "$code" -eq 137 ] && kills=$((kills + 1))
  done
  [ "$code" -eq 0 ] && pass || fail "a measurement after a kill ended with $code: $(cat killed.err)"
  echo "killed $kills times"
}
# expect_same_report PROTOCOL FOLDER FOLDER: every file except the cost.
expect_same_report() {
  local file each=frames.csv
  [ "$1" != digital ] || each=photographs.csv
  for file in "$1".{csv,json,md,svg,html} "$each" outcomes.npz settings.json; do
    expect_file "$2/$file"
    expect_same "$2/$file" "$3/$file"
  done
}
finish() {
  echo "$passes passed, $failures failed"
  [ "$failures" -eq 0 ]
}
