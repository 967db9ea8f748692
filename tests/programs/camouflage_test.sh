#!/usr/bin/env bash
# camouflage from the outside: what a run leaves behind, bits, resuming after any death, refusals.
source "$(dirname "$0")/support.sh"
camouflage=$programs/camouflage
[ -x "$camouflage" ] && [ -e "$sources/examples/assets/detector.weights" ] || exit 77
quick=(--scenes 40 --texels 32 --epochs 2 --checkpoint-steps 3)

expect_exit 0 "a short run" "$camouflage" "${quick[@]}" --threads 2 --output two
for file in manifest.json history.csv texture.png texture.npz painted.obj before.png after.png checkpoint.npz \
  metrics.json report.html; do expect_file "two/$file"; done
for key in photo clean adversarial controls asr seconds peak_mib seed options; do
  grep -q "\"$key\"" two/metrics.json && pass || fail "metrics.json lacks $key"
done

expect_exit 0 "the same seed again, one thread" "$camouflage" "${quick[@]}" --threads 1 --output one
expect_same one/texture.npz two/texture.npz
expect_same one/history.csv two/history.csv
expect_exit 0 "another seed" "$camouflage" "${quick[@]}" --seed 2 --output other
if cmp -s other/texture.npz two/texture.npz; then fail "another seed gives the same texture"; else pass; fi

# Killed at a random moment and resumed, again and again, until it is through: the same bits, no torn file.
RANDOM=7
mkdir -p killed
kills=0
resume=()
while [ ! -e killed/metrics.json ] && [ "$kills" -lt 60 ]; do
  "$camouflage" "${quick[@]}" --output killed "${resume[@]}" >/dev/null 2>killed.err &
  process=$!
  if [ "$kills" -lt 20 ]; then
    sleep "0.$((RANDOM % 9 + 1))"
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
  if [ -e killed/manifest.json ]; then resume=(--resume); fi
done
echo "killed $kills times"
expect_same killed/texture.npz two/texture.npz
expect_same killed/history.csv two/history.csv

# Stopped politely: saves, says how to go on, and goes on to the same bits.
long=(--scenes 40 --texels 32 --epochs 60 --checkpoint-steps 1000)
"$camouflage" "${long[@]}" --output stopped >/dev/null 2>stopped.err &
process=$!
for _ in $(seq 100); do
  [ -e stopped/manifest.json ] && break
  sleep 0.1
done
sleep 1
kill -INT "$process"
wait "$process"
code=$?
if [ "$code" -eq 130 ]; then
  pass
  grep -q -- "--resume" stopped.err && pass || fail "no word on how to resume"
  expect_file stopped/checkpoint.npz
elif [ "$code" -eq 0 ]; then echo "the run was over before the signal"; else fail "SIGINT: exit code $code"; fi

expect_exit 7 "a folder that holds a run" "$camouflage" "${quick[@]}" --output two
expect_error_line 'two already holds a run'
expect_exit 7 "resume with another seed" "$camouflage" --seed 9 --resume --output two
expect_error_line '\-\-seed \(was 1, now 9\)'
expect_exit 3 "resume where nothing is" "$camouflage" --resume --output nowhere
expect_exit 2 "a misspelt option" "$camouflage" --epoch 3
expect_error_line 'did you mean --epochs'
expect_exit 2 "an unknown loss" "$camouflage" --loss hinge
expect_exit 2 "a number that is none" "$camouflage" --epochs few
expect_exit 3 "a missing mesh" "$camouflage" --mesh absent.obj --material body --output absent
expect_error_line 'absent.obj'
expect_exit 4 "a missing class" "$camouflage" --class unicorn --output absent
expect_exit 4 "a missing material" "$camouflage" --mesh "$sources/examples/assets/car_sedan.obj" --material paint --output absent
[ -e absent ] && fail "a refused run left a folder behind" || pass
touch file
expect_exit 5 "a file in the folder's place" "$camouflage" "${quick[@]}" --output file
mkdir frames && cp "$sources"/examples/assets/frames/test/*.npz frames
first=$(ls frames | head -n 1)
head -c 500 "frames/$first" >cut && mv cut "frames/$first"
expect_exit 3 "check with a cut frame" "$camouflage" --check --frames frames
expect_error_line "frames/$first"
printf '[net]\nwidth=64\n' >broken.cfg
expect_exit 3 "check with several problems" "$camouflage" --check --frames frames --cfg broken.cfg --weights absent.weights
if [ "$(grep -c '^error: ' command.err)" -ge 2 ]; then pass; else fail "--check does not list all problems"; fi
expect_exit 0 "check of sound inputs" "$camouflage" --check
expect_exit 0 "help" "$camouflage" --help
finish
