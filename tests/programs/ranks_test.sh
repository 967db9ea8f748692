#!/usr/bin/env bash
# evaluate --protocol and camouflage under mpirun: the same files from any number of ranks, after the death of one, too.
source "$(dirname "$0")/support.sh"
needs evaluate camouflage
command -v mpirun >/dev/null && ldd "$evaluate" | grep -q libmpi || exit 77

# All ranks on this machine, started by any user; no remote shell, no memory of another process.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_plm=isolated
export OMPI_MCA_btl_vader_single_copy_mechanism=none
here=(--oversubscribe --bind-to none)
ranks() { # ranks COUNT OPTION...
  mpirun -n "$1" "${here[@]}" "$evaluate" --threads 1 "${@:2}"
}
# kill_last_rank PROCESS: of the ranks that this mpirun has started.
kill_last_rank() {
  kill -KILL "$(awk -v parent="$1" '$4 == parent { print $1 }' /proc/[0-9]*/stat 2>/dev/null | tail -n 1)"
}

mkdir frames && cp "$assets"/frames/test/00[01].npz frames
"$camouflage" --frames frames --texels 8 --epochs 1 --output run >/dev/null 2>&1
small=(--protocol views --run run --quick --controls matched --size 64 --background 0.5 0.5 0.5)
expect_exit 0 "without mpirun" "$evaluate" "${small[@]}" --threads 1 --output alone
cp command.out alone.out
for count in 1 2 3; do
  expect_exit 0 "$count ranks" ranks "$count" "${small[@]}" --output "ranks$count"
  expect_same_report views alone "ranks$count"
  expect_same <(grep -v '^this process\|^written' command.out) <(grep -v '^this process\|^written' alone.out)
  [ "$(grep -c 'frame 432 of 432' command.err)" -eq 1 ] && pass || fail "progress of $count ranks: $(cat command.err)"
done

# One of two ranks is killed after a checkpoint: the run ends, and continues with three.
touch started
mpirun -n 2 "${here[@]}" "$evaluate" --threads 1 "${small[@]}" --output killed >/dev/null 2>killed.err &
process=$!
wait_for 60 [ killed/outcomes.npz -nt started ]
kill_last_rank "$process"
wait "$process"
[ $? -ne 0 ] && pass || fail "the death of a rank was not seen"
expect_exit 0 "going on" ranks 3 "${small[@]}" --output killed
expect_same_report views alone killed

# Views of a step are shared: five frames in steps of three and two.
cp "$assets"/frames/test/00[2-4].npz frames
paint=(--frames frames --texels 8 --batch 3 --conditions light --worst-views 0.5 --printability 2 --checkpoint-steps 1
  --threads 1)
expect_same_run() { expect_same_files "$1" "$2" texture.npz texture.png checkpoint.npz history.csv metrics.csv manifest.json; } # FOLDER FOLDER
expect_exit 0 "a camouflage without mpirun" "$camouflage" "${paint[@]}" --epochs 4 --output paint
for count in 1 2 3; do
  expect_exit 0 "a camouflage by $count ranks" mpirun -n "$count" "${here[@]}" "$camouflage" "${paint[@]}" --epochs 4 \
    --output "paint$count"
  expect_same_run paint "paint$count"
  [ "$(grep -c '^  adversarial ' command.out)" -eq 1 ] && pass || fail "results of $count ranks"
done
mpirun -n 2 "${here[@]}" "$camouflage" "${paint[@]}" --epochs 30 --output dead >/dev/null 2>dead.err &
process=$!
wait_for 60 [ -e dead/checkpoint.npz ]
kill_last_rank "$process"
wait "$process"
[ $? -ne 0 ] && pass || fail "the death of a rank was not seen"
[ -e dead/report.html ] && fail "the run ended before its rank was killed" || pass
expect_exit 0 "going on with three" mpirun -n 3 "${here[@]}" "$camouflage" --resume --output dead --threads 1
expect_exit 0 "the same in one go, without mpirun" "$camouflage" "${paint[@]}" --epochs 30 --output whole
expect_same_run whole dead

# Refusals end all ranks with the exit code of one process.
expect_exit 2 "ranks without a protocol" ranks 2 --run run
grep -Eq '^error: (rank 1: )?several ranks' command.err && pass || fail "no word on ranks: $(cat command.err)"
expect_exit 7 "another measurement in the folder" ranks 2 "${small[@]}" --seed 5 --output alone
expect_same_report views alone ranks1

# Ranks that would compute something else are refused before the first step; they neither mix nor wait for ever.
for rank in 0 1; do
  mkdir "machine$rank" && cp -r frames run "machine$rank" && cp "$assets"/detector.{cfg,weights,names} "machine$rank"
done
printf '\0' | dd of=machine1/detector.weights bs=1 seek=5000 conv=notrunc status=none
foreign=(--cfg detector.cfg --weights detector.weights --names detector.names --threads 1)
two_machines() { # two_machines PROGRAM OPTION...: a rank in each folder
  timeout 120 mpirun "${here[@]}" -n 1 -wdir machine0 "$@" : -n 1 -wdir machine1 "$@"
}
expect_exit 4 "other weights at one rank" two_machines "$camouflage" "${foreign[@]}" --frames frames --texels 8 --epochs 1 --output mixed
grep -Eq '^error: (rank 1: )?options and inputs of rank [01] are others' command.err && pass || fail "mixed: $(cat command.err)"
[ -e machine0/mixed/history.csv ] && fail "ranks of different detectors took a step" || pass
expect_exit 4 "other epochs at one rank" timeout 120 mpirun "${here[@]}" -n 1 "$camouflage" "${paint[@]}" --epochs 4 --output unequal \
  : -n 1 "$camouflage" "${paint[@]}" --epochs 5 --output unequal
grep -Eq 'options and inputs of rank [01] are others' command.err && pass || fail "unequal: $(cat command.err)"
expect_exit 4 "a measurement by two detectors" two_machines "$evaluate" "${foreign[@]}" --protocol views --clean-only --quick \
  --size 64 --background 0.5 0.5 0.5 --output measured
grep -Eq 'settings and inputs of rank [01] are others' command.err && pass || fail "measured: $(cat command.err)"
finish
