#!/usr/bin/env bash
# evaluate --protocol under mpirun: the same files from any number of ranks, after the death of one, too.
source "$(dirname "$0")/support.sh"
evaluate=$programs/evaluate
assets=$sources/examples/assets
[ -x "$evaluate" ] && [ -x "$programs/camouflage" ] && command -v mpirun >/dev/null && ldd "$evaluate" | grep -q libmpi || exit 77

# All ranks on this machine, by whoever runs the tests; no remote shell, no memory of another process.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_plm=isolated
export OMPI_MCA_btl_vader_single_copy_mechanism=none
here=(--oversubscribe --bind-to none "$evaluate" --threads 1)
ranks() { # ranks COUNT OPTION...
  mpirun -n "$1" "${here[@]}" "${@:2}"
}

mkdir frames && cp "$assets"/frames/test/00[01].npz frames
"$programs/camouflage" --frames frames --texels 8 --epochs 1 --output run >/dev/null 2>&1
small=(--protocol views --run run --quick --controls matched --size 64 --background 0.5 0.5 0.5)
expect_same_report() { # expect_same_report FOLDER FOLDER
  local file
  for file in views.{csv,json,md,svg,html} outcomes.npz settings.json; do
    expect_file "$1/$file"
    expect_same "$1/$file" "$2/$file"
  done
}

expect_exit 0 "without mpirun" "$evaluate" "${small[@]}" --threads 1 --output alone
cp command.out alone.out
for count in 1 2 3; do
  expect_exit 0 "$count ranks" ranks "$count" "${small[@]}" --output "ranks$count"
  expect_same_report alone "ranks$count"
  expect_same <(grep -v '^this process\|^written' command.out) <(grep -v '^this process\|^written' alone.out)
  [ "$(grep -c 'frame 432 of 432' command.err)" -eq 1 ] && pass || fail "progress of $count ranks: $(cat command.err)"
done

# One of two ranks is killed after something was saved: the run ends, and goes on with three.
touch started
mpirun -n 2 "${here[@]}" "${small[@]}" --output killed >/dev/null 2>killed.err &
process=$!
wait_for 60 [ killed/outcomes.npz -nt started ]
last_rank=$(awk -v parent="$process" '$4 == parent { print $1 }' /proc/[0-9]*/stat 2>/dev/null | tail -n 1)
kill -KILL "$last_rank"
wait "$process"
[ $? -ne 0 ] && pass || fail "the death of a rank was not seen"
expect_exit 0 "going on" ranks 3 "${small[@]}" --output killed
expect_same_report alone killed

# Refusals end all ranks with the exit code of one process.
expect_exit 2 "ranks without a protocol" ranks 2 --run run
grep -Eq '^error: (rank 1: )?several ranks' command.err && pass || fail "no word on ranks: $(cat command.err)"
expect_exit 7 "another measurement in the folder" ranks 2 "${small[@]}" --seed 5 --output alone
expect_same_report alone ranks1
finish
