#!/usr/bin/env bash
# The scripts of examples/experiments when they are started twice, killed, short of disk, or find other inputs: one error, and
# then the same tables. (F32)
source "$(dirname "$0")/support.sh"
experiments=$sources/examples/experiments
[ "$programs" = "$sources/build/release/examples" ] && [ -x "$programs/tabulate" ] || exit 77
mkdir -p own/train own/test mine
cp "$assets"/frames/test/00[01].npz own/test
cp "$assets"/frames/test/01[01].npz own/train
cp "$assets"/detector.{cfg,weights,names} mine
common="--frames $PWD/own --texels 4 --size 64 --batch 1 --epochs 1 --threads 1 --cfg $PWD/mine/detector.cfg --weights $PWD/mine/detector.weights --names $PWD/mine/detector.names"
export SEEDS=1 DRAWS=1 QUICK=yes

# variants_in FOLDER VARIANT...: the command in a folder of its own, so that the paths in its files are the same.
variants_in() { mkdir -p "$1" && cd "$1" && exec bash "$experiments/variants.sh" out "$common" "${@:2}"; }
both=(first= "second=--loss vanish")
expect_exit 0 "undisturbed" eval '(variants_in whole "${both[@]}")'
expect_same_tables() { # FOLDER
  local kind
  for kind in csv json md tex svg; do expect_same whole/out/tables/variants.$kind "$1/out/tables/variants.$kind"; done
  expect_same whole/out/tables/index.html "$1/out/tables/index.html"
  no_locks "$1"
}
# at_work FILE PROCESS: waits until a program has made its lock, or all programs have ended.
at_work() {
  while [ ! -e "$1" ] && kill -0 "$2" 2>/dev/null; do sleep 0.02; done
}
no_locks() { [ -z "$(find "$1" -name '.*lock')" ] && pass || fail "a lock is left: $(find "$1" -name '.*lock')"; }
goes_on() { # FOLDER
  expect_exit 0 "$1, gone on with" eval "(variants_in $1 \"\${both[@]}\")"
  expect_same_tables "$1"
}

# Started twice.
(variants_in twice "${both[@]}") >/dev/null 2>first.err &
process=$!
at_work "twice/out/runs/first-1" "$process"
expect_refusal 7 "^error: out: folder is in use by process $process on " "started twice" eval '(variants_in twice "${both[@]}")'
wait "$process" && pass || fail "the first of two: $(cat first.err)"
expect_same_tables twice

# Stopped by a signal that only the script gets, while a program works: no lock stays, and no program continues.
for signal in TERM INT HUP; do
  for folder in runs/first-1 measured/digital-first-1 runs/second-1; do
    (variants_in "stopped-$signal" "${both[@]}") >/dev/null 2>&1 &
    process=$!
    at_work "stopped-$signal/out/$folder/.lock" "$process"
    kill "-$signal" "$process" 2>/dev/null
    wait "$process" 2>/dev/null
    code=$?
    [ "$code" = 0 ] || [ "$code" = $((128 + $(kill -l $signal))) ] && pass || fail "SIG$signal: exit status $code"
    no_locks "stopped-$signal"
  done
  goes_on "stopped-$signal"
done

# Killed at any time, with all its child processes.
for tenths in 1 3 5 8 12 17 23; do
  (variants_in killed "${both[@]}") >/dev/null 2>&1 &
  process=$!
  sleep "$((tenths / 10)).$((tenths % 10))"
  kill -KILL -- "-$process" 2>/dev/null
  wait "$process" 2>/dev/null
done
goes_on killed
# The script alone killed: its child ends by itself; until then the same command is refused or does other work.
(variants_in orphan "${both[@]}") >/dev/null 2>&1 &
process=$!
at_work "orphan/out/runs/first-1/.lock" "$process"
stop KILL "$process"
(variants_in orphan "${both[@]}") >command.out 2>command.err
code=$?
[ "$code" = 0 ] || { [ "$code" = 7 ] && grep -q '^error: .*in use by process' command.err; } && pass || fail "beside an orphan: $code, $(cat command.err)"
wait_for 60 eval '! [ -e orphan/out/runs/first-1/.lock ]'
goes_on orphan

# A detector exchanged between two calls, and between two steps of one call.
cp mine/detector.weights kept && cp kept changed && printf '\0' | dd of=changed bs=1 seek=5000 conv=notrunc status=none
for file in mine/detector.weights mine/detector.names own/test/001.npz; do
  name=exchanged-$(basename "$file")
  cp "$file" before
  expect_exit 0 "the first half" eval "(variants_in $name first=)"
  case $file in *.weights) cp changed "$file" ;; *.names) sed -i 's/van/bus/' "$file" ;; *) cp own/test/000.npz "$file" ;; esac
  expect_exit 7 "$file exchanged between two calls" eval "(variants_in $name \"\${both[@]}\")"
  expect_error_line "^error: out: $PWD/$file has changed since it was read \(SHA-256 [0-9a-f]{16}, found $(sha256sum <"$file" | cut -c 1-16)\)"
  [ -e "$name/out/runs/second-1" ] && fail "it was used all the same" || pass
  cp before "$file"
  goes_on "$name"
done
cat >exchange <<END
#!/usr/bin/env bash
[[ "\$*" != *second-1* ]] || cp $PWD/changed $PWD/mine/detector.weights
exec "\$@"
END
chmod +x exchange
LAUNCH=$PWD/exchange expect_exit 7 "exchanged between two steps" eval '(variants_in steps "${both[@]}")'
expect_error_line "^error: out: its steps do not go together: $PWD/mine/detector.weights was read with SHA-256 [0-9a-f]{16} and with [0-9a-f]{16}\$"
[ -e steps/out/tables ] && fail "a table of two detectors" || pass
cp kept mine/detector.weights

# Files that may not grow, as on a disk that fills: one error, whichever step meets it.
for blocks in 1 4 16 64; do
  (ulimit -f "$blocks" && variants_in "limited-$blocks" "${both[@]}") >command.out 2>command.err
  code=$?
  [ "$code" = 5 ] && pass || fail "files of $blocks KiB: exit status $code: $(cat command.err)"
  expect_error_line '.'
  goes_on "limited-$blocks"
done
mkdir -p disk/out
if mount -t tmpfs -o size=4k tapestry disk/out 2>/dev/null; then
  trap 'umount disk/out' EXIT
  refusals=0
  for size in 4k 20k 60k 150k 300k 500k 800k 1200k 2000k 32m; do
    mount -o remount,size=$size disk/out
    (variants_in disk "${both[@]}") >command.out 2>command.err
    code=$?
    [ "$code" = 0 ] || { [ "$code" = 5 ] && [ "$(grep -c . command.err)" -ge 1 ]; } && pass || fail "a disk of $size: $code, $(cat command.err)"
    [ "$code" = 0 ] || refusals=$((refusals + 1))
  done
  [ "$refusals" -ge 3 ] && pass || fail "only $refusals disks were too small"
  goes_on disk
fi

# Options of a row replace COMMON's, and paper.sh works by the same steps.
export COMMON="$common --start zero" FRAMES=$PWD/own EPOCHS=1
paper_in() { mkdir -p "$1" && cd "$1" && exec bash "$experiments/paper.sh" out --quick --tables 7; }
COMMON=${COMMON/--frames $PWD\/own /} COMMON=${COMMON/--epochs 1 /}
expect_exit 0 "table 7" eval '(paper_in paper)'
grep -q '"start": "own"' paper/out/runs/own_start-1/manifest.json && pass || fail "a row's own option does not count"
for folder in runs/own_start-1 measured/digital-random_start-1; do
  (paper_in paper-stopped) >/dev/null 2>&1 &
  process=$!
  at_work "paper-stopped/out/$folder/.lock" "$process"
  kill "$process" 2>/dev/null
  wait "$process" 2>/dev/null
  no_locks paper-stopped
done
expect_exit 0 "table 7, gone on with" eval '(paper_in paper-stopped)'
for kind in csv json md tex svg; do expect_same paper/out/tables/7-starts.$kind paper-stopped/out/tables/7-starts.$kind; done
unset FRAMES
(paper_in drawn) >/dev/null 2>&1 &
process=$!
at_work "drawn/out/frames/.lock" "$process"
expect_refusal 7 "^error: out: folder is in use by process $process on " "started twice while frames are drawn" eval '(paper_in drawn)'
kill "$process"
wait "$process" 2>/dev/null
no_locks drawn
LENGTH=4 expect_exit 7 "a car of another length" eval '(paper_in drawn)'
expect_error_line 'was begun with other settings'
finish
