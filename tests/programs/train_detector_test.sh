#!/usr/bin/env bash
# train_detector from the outside.
source "$(dirname "$0")/support.sh"
train=$programs/train_detector
[ -x "$train" ] || exit 77
small="--batch 2 --fresh 1 --pool 4 --validate 2"

expect_repeatable_training weights "P@0.5"

"$train" $small --steps 1000000 --output "it's stopped.weights" >command.out 2>stopped.err &
child=$!
wait_for 60 grep -q '^step 1 ' stopped.err
expect_exit 7 "another training to the same file" "$train" $small --steps 1 --output "it's stopped.weights"
expect_error_line "it's stopped.weights: file is in use by process $child"
stop TERM "$child"
[ $? -eq 143 ] && pass || fail "stopping did not end with 143"
expect_file "it's stopped.weights"
ls -A | grep -q 'lock$' && fail "a lock is left behind" || pass
eval "go_on() { exec $(tail -n 1 stopped.err); }"
(go_on >command.out 2>command.err) &
child=$!
wait_for 60 grep -q '^step 1 ' command.err
stop INT "$child"
[ $? -eq 130 ] && pass || fail "the command to go on does not work when pasted"

expect_refusal 2 'did you mean --steps' "a misspelt option" "$train" --stepz 3
expect_exit 2 "an empty batch" "$train" --batch 0
expect_senseless "$train --output refused.weights" "--steps -3" "--learning-rate nan" "--threads 1000000" "--validate 1000000000000" "--batch 100000000"
mkdir folder
expect_exit 5 "a folder in the file's place" "$train" $small --output folder
[ -e refused.weights ] && fail "a refused run wrote weights" || pass
expect_refusal 3 'absent.weights' "missing weights" "$train" --weights absent.weights --steps 0
expect_refusal 5 'absent/x.weights' "a missing folder" "$train" $small --output absent/x.weights
finish
