#!/usr/bin/env bash
# Inputs of a run are known by their bytes: a resumed run and a measurement notice any exchange.
source "$(dirname "$0")/support.sh"
needs camouflage evaluate

mkdir frames mine
cp "$assets"/frames/test/00[01].npz frames
cp "$assets"/car_sedan.{obj,mtl} "$assets"/detector.{cfg,weights,names} mine
expect_exit 0 "a second detector, as a model with its description" "$programs/convert_weights" --cfg mine/detector.cfg \
  --weights mine/detector.weights --output mine/second.onnx
printf '0.1 0.1 0.1\n0.9 0.9 0.9\n' >mine/colours.txt
run=(--frames frames --texels 8 --epochs 1 --mesh mine/car_sedan.obj --material body --cfg mine/detector.cfg
  --weights mine/detector.weights --names mine/detector.names --ensemble mine/second.onnx --printability 1
  --palette mine/colours.txt)
expect_exit 0 "a first run" "$camouflage" --frames frames --texels 8 --epochs 1 --output first
expect_exit 0 "a run" "$camouflage" "${run[@]}" --start first/texture.npz --output run
expect_exit 0 "resumed with the same" "$camouflage" --resume --output run
for file in mine/* frames/*.npz first/texture.npz; do
  grep -q "\"path\": \"$file\", *$\|\"path\": \"$file\"" run/manifest.json && pass || fail "the manifest lacks $file"
  grep -q "\"sha256\": \"$(sha256sum <"$file" | cut -d' ' -f1)\"" run/manifest.json && pass || fail "another hash of $file"
done

# Exchanges each for a file that differs by a byte, or is no longer read at all.
exchanged() { # exchanged FILE COMMAND...: changes a copy of the file by the command, and puts it back afterwards
  local file=$1
  shift
  cp "$file" kept && "$@" "$file"
  expect_refusal 7 "inputs have changed: $file \(expected SHA-256 [0-9a-f]{16}, found SHA-256 [0-9a-f]{16}\)$" "resumed with another $file" "$camouflage" --resume --output run
  cp kept "$file"
}
add_line() { echo >>"$1"; }
for file in mine/{car_sedan.mtl,car_sedan.obj,detector.cfg,colours.txt}; do exchanged "$file" add_line; done
cp mine/detector.weights changed.weights && printf '\0' | dd of=changed.weights bs=1 seek=5000 conv=notrunc status=none
expect_exit 0 "another second detector" "$programs/convert_weights" --cfg mine/detector.cfg --weights changed.weights \
  --output changed.onnx
exchanged mine/second.onnx cp changed.onnx
exchanged mine/detector.weights cp changed.weights
exchanged mine/detector.names sed -i 's/van/bus/'
exchanged first/texture.npz cp run/texture.npz
exchanged frames/000.npz cp frames/001.npz
expect_exit 0 "resumed with what it was" "$camouflage" --resume --output run

# Masks beside frames, and the network that finds masks.
mkdir -p masked/masks
cp frames/*.npz masked
for frame in 000 001; do
  expect_exit 0 "a mask of $frame" "$programs/render" --frame "frames/$frame.npz" --view coverage --size 416 --output "masked/masks/$frame.png"
done
cp "$assets/segmenter.onnx" mine/segmenter.onnx
exchanged_in() { # RUN FILE NEW
  cp "$2" kept && cp "$3" "$2"
  expect_refusal 7 "inputs have changed: $2 \(expected SHA-256 [0-9a-f]{16}, found SHA-256 [0-9a-f]{16}\)$" "$1 resumed with another $2" "$camouflage" --resume --output "$1"
  expect_refusal 7 "inputs have changed since the run: $2 " "$1 measured with another $2" "$evaluate" --run "$1" --output other
  cp kept "$2"
}
small=(--texels 8 --epochs 1 --size 64)
expect_exit 0 "a run with masks of files" "$camouflage" --frames masked --mask file "${small[@]}" --output by-file
exchanged_in by-file masked/masks/000.png masked/masks/001.png
expect_exit 0 "a run with masks by a network" "$camouflage" --frames frames --mask u2net --segmenter mine/segmenter.onnx "${small[@]}" --output by-network
cp mine/segmenter.onnx another.onnx
printf '\1' | dd of=another.onnx bs=1 seek=$(($(stat -c %s another.onnx) / 2)) conv=notrunc status=none
exchanged_in by-network mine/segmenter.onnx another.onnx

# A file exchanged while the program runs: frames that are not kept are read again.
expect_exit 0 "enough frames" "$camouflage" --frames frames --texels 8 --epochs 1 --output short
(wait_for 60 [ -e long/manifest.json ] && cp frames/001.npz exchanged && mv exchanged frames/000.npz) &
expect_refusal 4 '^error: frames/000.npz: the file has changed since it was first read' "a frame exchanged during the run" "$camouflage" --frames frames --texels 8 --epochs 2000 --keep-mib 0 --output long
wait
cp "$assets/frames/test/000.npz" frames

# A measurement lists its inputs, and notices those that the run did not read.
expect_exit 0 "measured" "$evaluate" --run run --output measured
for file in run/texture.npz mine/detector.weights frames/001.npz; do
  grep -q "\"path\": \"$file\"" measured/metrics.json && pass || fail "metrics.json lacks $file"
  for page in run measured; do
    [ "$page" = run ] && [ "$file" = run/texture.npz ] && continue
    grep -q "<td>$file</td><td>[a-z ]*</td><td>$(stat -c %s "$file")</td><td>$(sha256sum <"$file" | cut -c 1-12)</td>" $page/report.html && pass ||
      fail "the page of $page lacks $file"
  done
done
sed -i 's/van/bus/' mine/detector.names
expect_refusal 7 'inputs have changed since the run: mine/detector.names' "measured with other names" "$evaluate" --run run --output other

finish
