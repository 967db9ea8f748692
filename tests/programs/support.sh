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
# expect_same_files FOLDER FOLDER FILE...: files of these names in both folders have the same bytes.
expect_same_files() {
  local file
  for file in "${@:3}"; do expect_same "$1/$file" "$2/$file"; done
}
# expect_senseless "COMMAND..." "OPTION VALUE"...: each is refused by the option's name.
expect_senseless() {
  local words
  # shellcheck disable=SC2086  # several words on purpose
  for words in "${@:2}"; do expect_refusal 2 "^error: ${words% *}" "$words" $1 $words; done
}
# expect_words "FILE..." WORDS...: every file has all of these.
expect_words() {
  local words file
  for words in "${@:2}"; do
    for file in $1; do grep -qF -- "$words" "$file" && pass || fail "$file says nothing of '$words'"; done
  done
}
# stop SIGNAL PROCESS: sends a signal and waits; the exit code is the process's.
stop() {
  kill "-$1" "$2" 2>/dev/null
  wait "$2" 2>/dev/null
}
# label_picture NAME VOC FIRST STEP: writes the labels of yolo/images/NAME.png in three forms. Rows of NAME.boxes are class, x, y,
# width and height; VOC is the folder of the XML; COCO has the classes FIRST + STEP times the class, in images.part and
# annotations.part.
label_picture() {
  local width height id
  id=$(($(cat images.part 2>/dev/null | wc -l) + 1))
  read -r width height < <(od -An -j16 -N8 -tu1 "yolo/images/$1.png" | awk '{ print $3 * 256 + $4, $7 * 256 + $8 }')
  awk -v w="$width" -v h="$height" '{ printf "%d %.17g %.17g %.17g %.17g\n", $1, ($2 + $4 / 2) / w, ($3 + $5 / 2) / h,
    $4 / w, $5 / h }' "$1.boxes" >"yolo/labels/$1.txt"
  {
    echo "<annotation><filename>$1.png</filename><size><width>$width</width><height>$height</height></size>"
    awk 'NR == FNR { names[FNR - 1] = $0; next } { printf "<object><name>%s</name><bndbox><xmin>%d</xmin><ymin>%d</ymin>" \
      "<xmax>%d</xmax><ymax>%d</ymax></bndbox></object>\n", names[$1], $2 + 1, $3 + 1, $2 + $4, $3 + $5 }' \
      "$assets/detector.names" "$1.boxes"
    echo "</annotation>"
  } >"$2/$1.xml"
  echo "{\"id\": $id, \"file_name\": \"$1.png\", \"width\": $width, \"height\": $height}" >>images.part
  awk -v id="$id" -v first="$3" -v step="$4" '{ printf "{\"id\": %d, \"image_id\": %d, \"category_id\": %d, " \
    "\"bbox\": [%d, %d, %d, %d], \"iscrowd\": 0}\n", 1000 * id + FNR, id, first + step * $1, $2, $3, $4, $5 }' \
    "$1.boxes" >>annotations.part
}
# boxes_of PICTURE: rows of class, x, y, width and height of what the bundled detector finds.
boxes_of() {
  "$programs/detect" --quiet --json --confidence 0.3 "$1" |
    awk -F '[:,]' '/"class"/ { class = $2 } /"x"/ { x = $2 } /"y"/ { y = $2 } /"width"/ { w = $2 }
      /"height"/ { printf "%d %d %d %d %d\n", class, x, y, w, $2 }'
}
# joined FILE: its lines with commas between them.
joined() { paste -sd , "$1"; }
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
# expect_repeatable_training ENDING WORDS: $train with the options $small has a help, ends with WORDS, gives one.ENDING on any number
# of threads and other weights by another seed, and writes none where it only validates.
expect_repeatable_training() {
  expect_exit 0 "help" "$train" --help
  grep -q -- '--learning-rate' command.out && pass || fail "help lacks an option"
  # shellcheck disable=SC2086  # several words on purpose
  expect_exit 0 "three steps on one thread" "$train" $small --steps 3 --seed 7 --threads 1 --output "one.$1"
  grep -q "$2" command.out && pass || fail "no validation at the end"
  expect_exit 0 "three steps on two threads" "$train" $small --steps 3 --seed 7 --threads 2 --output "two.$1"
  expect_same "one.$1" "two.$1"
  expect_exit 0 "another seed" "$train" $small --steps 3 --seed 8 --output "other.$1"
  cmp -s "one.$1" "other.$1" && fail "two seeds give the same weights" || pass
  expect_exit 0 "only validation" "$train" $small --steps 0 --weights "one.$1" --output "none.$1"
  [ -e "none.$1" ] && fail "validation alone wrote weights" || pass
}
finish() {
  echo "$passes passed, $failures failed"
  [ "$failures" -eq 0 ]
}
