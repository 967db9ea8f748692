#!/usr/bin/env bash
# detect and evaluate from the outside.
source "$(dirname "$0")/support.sh"
detect=$programs/detect
assets=$sources/examples/assets
[ -x "$detect" ] && [ -e "$assets/detector.weights" ] || exit 77
frame=$(ls "$assets"/frames/test/*.npz | head -n 1)

expect_exit 0 "a table" "$detect" "$frame"
grep -q '^  car ' command.out && pass || fail "no car in the table"
expect_exit 0 "json" "$detect" --json --annotate drawn "$frame" "$frame"
for key in image detections class name confidence x y width height; do
  grep -q "\"$key\"" command.out && pass || fail "json lacks $key"
done
expect_file "drawn/$(basename "$frame" .npz)-detections.png"
expect_exit 0 "a PNG" "$detect" --json "drawn/$(basename "$frame" .npz)-detections.png"
expect_exit 3 "a missing picture" "$detect" absent.png
expect_error_line 'absent.png'
expect_exit 2 "no picture" "$detect"
expect_exit 2 "weights without cfg" "$detect" --weights "$assets/detector.weights" "$frame"
head -c 5000 "$assets/detector.weights" >cut.weights
expect_exit 3 "cut weights" "$detect" --cfg "$assets/detector.cfg" --weights cut.weights "$frame"
expect_error_line 'cut.weights'
printf '<html>not found</html>' >page.weights
expect_exit 3 "a page instead of weights" "$detect" --cfg "$assets/detector.cfg" --weights page.weights "$frame"
expect_error_line 'page.weights.*HTML'

evaluate=$programs/evaluate
expect_exit 0 "evaluate without a texture" "$evaluate" --clean-only --sweep 0.25 --output measured
expect_file measured/metrics.json
expect_exit 2 "evaluate without a run" "$evaluate"
finish
