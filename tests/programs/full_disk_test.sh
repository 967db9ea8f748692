#!/usr/bin/env bash
# Disks that are full or read-only: one error, no file half written, and the run continues when there is room. Uses a
# small disk in memory, which needs the right to mount.
source "$(dirname "$0")/support.sh"
needs camouflage
disk=$PWD/disk
mkdir disk
mount -t tmpfs -o size=64k tapestry "$disk" 2>/dev/null || { echo "no right to mount: skipped"; exit 77; }
trap 'umount "$disk"' EXIT
conversion=("$programs/convert_weights" --cfg "$assets/detector.cfg" --weights "$assets/detector.weights")
expect_refusal 5 'disk/weights.*No space left' "weights on a disk that is too small" "${conversion[@]}" --output "$disk/weights.onnx"
[ -z "$(ls -A "$disk")" ] && pass || fail "weights that did not fit left $(ls -A "$disk")"

quick=(--scenes 20 --texels 32 --epochs 1 --checkpoint-steps 2)
expect_exit 0 "a run with room" "$camouflage" "${quick[@]}" --output roomy
expect_refusal 5 'disk/run.*No space left' "a run on a disk that fills" "$camouflage" "${quick[@]}" --output "$disk/run"
for file in "$disk"/run/* "$disk"/run/.[!.]*; do
  [ ! -e "$file" ] || [ -e "roomy/$(basename "$file")" ] && pass || fail "$file stays"
done
mount -o remount,size=64m "$disk"
resume=()
[ ! -e "$disk/run/manifest.json" ] || resume=(--resume)
expect_exit 0 "the run, with room again" "$camouflage" "${quick[@]}" --output "$disk/run" "${resume[@]}"
expect_same_files "$disk/run" roomy texture.npz metrics.csv

mount -o remount,ro "$disk"
expect_refusal 5 'disk/weights.*Read-only' "weights on a read-only disk" "${conversion[@]}" --output "$disk/weights.onnx"
expect_refusal 5 'disk/another.*Read-only' "a run on a read-only disk" "$camouflage" "${quick[@]}" --output "$disk/another"
finish
