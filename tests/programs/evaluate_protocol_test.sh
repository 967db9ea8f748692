#!/usr/bin/env bash
# evaluate --protocol from the outside: the same files by any number of threads and after any death, refusals.
source "$(dirname "$0")/support.sh"
needs evaluate camouflage

mkdir frames && cp "$assets"/frames/test/00[0-3].npz frames
expect_exit 0 "a camouflage" "$programs/camouflage" --frames frames --texels 8 --epochs 1 --output run
small=(--run run --quick --controls matched --size 128 --background 0.5 0.5 0.5)

expect_exit 0 "views, two threads" "$evaluate" --protocol views "${small[@]}" --threads 2 --output two
grep -Eq '^views: frame 432 of 432, each with 5 textures, 0 s left' command.err && pass || fail "no word on how far it is"
grep -q 'worst cell: ' command.out && pass || fail "no worst cell"
expect_words "command.out two/views.md two/views.html two/views.json" 'seed 1' 'confidence above 0.25' 'IoU 0.45' \
  'half of the field of view is 30 degrees' '--quick'
grep -Eq '^this process: [0-9.]+ s for 432 frames, peak memory [0-9]+ MiB, 2 threads' command.out && pass || fail "no cost"
grep -q '"seconds"' two/cost.json && pass || fail "cost.json lacks the seconds"
grep -Eq 'http-equiv|@import|(src|href)="[^d]' two/views.html && fail "the page needs other files" || pass
grep -q 'prefers-color-scheme: dark' two/views.svg && pass || fail "no colours for dark pages"

# A line each for 432 frames and 5 textures, which reproduce the cells' figures.
[ "$(wc -l <two/frames.csv)" -eq 2161 ] && pass || fail "frames.csv has $(wc -l <two/frames.csv) lines"
awk -F , 'NR == FNR { if (FNR > 1) { cell = substr($1, 2) "," substr($2, 2, length($2) - 2); found[cell "," $9] += $11; frames[cell "," $9]++ } next }
  $1 != "all" && FNR > 1 { if (found[$1 "," $2 "," $3] != $7 || frames[$1 "," $2 "," $3] != 9) exit 1; cells++ }
  END { exit cells != 240 }' two/frames.csv two/views.csv && pass || fail "frames.csv has other figures than views.csv"

# 48 cells and the whole, 5 textures each; the cells add up, and the pictures found in clean are the denominator.
[ "$(wc -l <two/views.csv)" -eq 246 ] && pass || fail "views.csv has $(wc -l <two/views.csv) lines"
awk -F , 'NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
  { frames = $column["frames"]; detected = $column["detected"]; clean = $column["detected_in_clean"]; hidden = $column["hidden"] + 0 }
  $1 == "all" { if (frames != sum_frames[$3] || detected != sum_detected[$3] || clean != sum_clean[$3] ||
      hidden != sum_hidden[$3] || clean != sum_detected["clean"]) exit 1; wholes++; next }
  { sum_frames[$3] += frames; sum_detected[$3] += detected; sum_clean[$3] += clean; sum_hidden[$3] += hidden }
  frames != 9 || hidden > clean || clean > frames { exit 1 }
  $3 != "clean" && clean > 0 && ($column["asr"] - hidden / clean) ^ 2 > 1e-12 { exit 1 }
  $3 == "clean" && $column["asr"] != "" || clean == 0 && $column["asr"] != "" { exit 1 }
  END { exit !(wholes == 5 && sum_frames["clean"] == 432 && sum_detected["clean"] > 20) }' two/views.csv && pass ||
  fail "the cells of views.csv do not add up"

expect_exit 0 "one thread" "$evaluate" --protocol views "${small[@]}" --threads 1 --output one
expect_same_report views one two

# Without a material file all but the paint is dark, as with a file that states so, and not light grey. The same for
# materials with only a texture that is missing.
mkdir bare absent stated
sed 's/^mtllib.*/mtllib dark.mtl/' "$assets/car_sedan.obj" | tee bare/car.obj absent/car.obj >stated/car.obj
grep ^newmtl "$assets/car_sedan.mtl" | sed 's/$/\nKd 0.09 0.09 0.10/; s/^newmtl body\nKd.*/newmtl body\nKd 0.8 0.8 0.8/' >stated/dark.mtl
grep ^newmtl "$assets/car_sedan.mtl" | sed 's/$/\nmap_Kd none.png/' >absent/dark.mtl
for mesh in bare absent stated; do
  expect_exit 0 "a car with a $mesh file" "$evaluate" --clean-only --protocol occlusion --quick --size 128 --background 0.5 0.5 0.5 \
    --mesh $mesh/car.obj --material body --output of_$mesh
  expect_exit 0 "its picture" "$programs/render" --mesh $mesh/car.obj --material body --colour 0.8 0.8 0.8 --size 96 --output $mesh.png
done
for mesh in bare absent; do
  expect_same of_$mesh/frames.csv of_stated/frames.csv
  expect_same $mesh.png stated.png
done

kill_until_measured killed --protocol occlusion "${small[@]}" # (F01)
expect_exit 0 "occlusion at one go" "$evaluate" --protocol occlusion "${small[@]}" --output whole
expect_same_report occlusion killed whole
grep -q 'overlap with that of the whole car' whole/occlusion.md && pass || fail "no word on the target box"
hidden_shares='NR > 1 && $1 != "all" { share = $6; group = $1 }
  group ~ /^small/ && !(share >= 0.05 && share <= 0.3) { exit 1 }
  group ~ /^middle/ && !(share > 0.3 && share < 0.7) { exit 1 }
  group ~ /^large/ && !(share >= 0.7 && share <= 0.95) { exit 1 }
  END { exit NR != lines }'
awk -F , -v lines=79 "$hidden_shares" whole/occlusion.csv && pass || fail "the hidden shares do not fit their groups"
for table in two/views.csv whole/occlusion.csv; do
  [ -z "$(head -n 1 "$table" | tr , '\n' | sort | uniq -d)" ] && pass || fail "two columns of $table have one name"
done
# Without a car only rectangles can be found, and nothing is hidden.
awk -F , '$3 == "no car" { rows++; if ($13 != "" || $14 != "") exit 1 } $1 == "all" { found[$3] = $7 }
  END { exit !(rows == 13 && found["no car"] < found["clean"]) }' whole/occlusion.csv && pass || fail "the rows without a car"
# Behind other vehicles: the same table; without the car only those vehicles.
expect_exit 0 "behind other vehicles" "$evaluate" --protocol traffic --run run --quick --controls matched --size 128 --output traffic
awk -F , -v lines=61 "$hidden_shares" traffic/traffic.csv && pass || fail "the shares hidden by vehicles do not fit their groups"
awk -F , '$1 == "all" { found[$3] = $7 } END { exit !(found["no car"] < found["clean"]) }' traffic/traffic.csv && pass ||
  fail "vehicles are found as often as the car"
expect_exit 0 "behind other vehicles, one thread" "$evaluate" --protocol traffic --run run --quick --controls matched --size 128 \
  --threads 1 --output traffic1
expect_same_report traffic traffic1 traffic
grep -q ',no car,' two/views.csv && fail "views without a car" || pass
cp whole/occlusion.csv before.csv
expect_exit 0 "again, with nothing left to do" "$evaluate" --protocol occlusion "${small[@]}" --output whole
grep -q '^this process: .* for 0 frames' command.out && pass || fail "frames were measured again"
expect_same whole/occlusion.csv before.csv

# Printed and photographed: besides each unchanged view, with any threads and after any death. (F01)
physical=(--protocol physical --run run --quick --controls matched --size 128)
expect_exit 0 "printed and photographed, two threads" "$evaluate" "${physical[@]}" --threads 2 --output physical
expect_words "command.out physical/physical.md physical/physical.html" 'photographed' 'effect beyond matched noise' 'worst cell: ' \
  'seed 1' 'confidence above 0.25' 'JPEG of quality 50 to 95'
expect_exit 0 "printed and photographed, one thread" "$evaluate" "${physical[@]}" --threads 1 --output physical1
expect_same_report physical physical1 physical
kill_until_measured physical2 "${physical[@]}"
expect_same_report physical physical2 physical
# 18 cells and two wholes, 4 textures each; 4 directions a cell; a photograph takes something from the car.
awk -F , 'NR > 1 && $2 != "all" { cells++; part = $1 ~ / as it is$/ ? "as it is" : "photographed"; frames[part, $3] += $4
    found[part, $3] += $7; if ($4 != 4) exit 1 }
  $2 == "all" { wholes++; if ($4 != 36 || $4 != frames[$1, $3] || $7 != found[$1, $3]) exit 1; sure[$1, $3] = $11 }
  END { exit !(cells == 72 && wholes == 8 && sure["photographed", "clean"] < sure["as it is", "clean"]) }' physical/physical.csv &&
  pass || fail "physical.csv does not add up"
expect_refusal 7 '--seed \(was 1, now 2\)' "other photographs by another seed" "$evaluate" "${physical[@]}" --seed 2 --output physical
expect_exit 0 "the plain car, photographed" "$evaluate" --protocol physical --clean-only --quick --size 128
grep -q 'worst cell: the plain car is found least at surroundings street [123], distance' command.out && pass || fail "no worst cell"
grep -q 'kept' command.out && fail "an effect of no camouflage" || pass
expect_exit 2 "a background of streets" "$evaluate" --protocol physical --clean-only --background 1 1 1
expect_error_line '^error: --background has no part in --protocol physical'
expect_exit 2 "frames of streets" "$evaluate" --protocol physical --clean-only --frames frames
expect_error_line '^error: --frames has no part in --protocol physical'

# Photographs: the figures of evaluate without a protocol, and the same again for the detector in another format.
expect_exit 0 "another format" "$programs/convert_weights" --cfg "$assets/detector.cfg" --weights "$assets/detector.weights" \
  --output second.onnx
photographs=(--protocol digital --run run --frames "$assets/frames/test" --further-weights second.onnx)
expect_exit 0 "photographs" "$evaluate" "${photographs[@]}" --quick --threads 2 --output digital
expect_exit 0 "photographs, one thread" "$evaluate" "${photographs[@]}" --quick --threads 1 --output digital1
expect_same_report digital digital1 digital
kill_until_measured digital2 "${photographs[@]}" --quick
expect_same_report digital digital2 digital
"$evaluate" "${photographs[@]}" --quick --output digital >command.out 2>&1
expect_words "command.out digital/digital.md digital/digital.html" 'effect beyond matched noise' 'P@0.5 by confidence threshold' \
  'at most 20 photographs' 'paired bootstrap' 'seed 1' 'made with 1 of these very photographs'
[ "$(wc -l <digital/digital.csv)" -eq 27 ] && pass || fail "digital.csv has $(wc -l <digital/digital.csv) lines"
[ "$(wc -l <digital/photographs.csv)" -eq 521 ] && pass || fail "photographs.csv has $(wc -l <digital/photographs.csv) lines"
# A quick measurement leaves frames out; a missing frame is an error.
mkdir many && cp "$assets"/frames/test/0[01]?.npz "$assets/frames/test/020.npz" many
expect_exit 0 "a camouflage of 21 frames" "$programs/camouflage" --frames many --texels 8 --epochs 1 --output of_many
quickly=(--protocol digital --run of_many --controls matched --quick --output quickly)
expect_exit 0 "20 of its frames" "$evaluate" "${quickly[@]}"
mv many/020.npz ./020.npz
expect_exit 7 "a frame that is gone" "$evaluate" "${quickly[@]}"
expect_error_line 'inputs have changed since the run: many/020.npz \(expected SHA-256 [0-9a-f]{16}, found none\)'
mkdir 'a, "b"' && cp "$assets/frames/test/000.npz" 'a, "b"'
expect_exit 0 "a folder with a comma" "$evaluate" --protocol digital --clean-only --frames 'a, "b"' --output comma
[ "$(grep -c '^detector,[a-z]*,[01],[0-9.e-]*,,[a-z]*,[a-z]*,"a, ""b""/000.npz"$' comma/photographs.csv)" -eq 2 ] && pass ||
  fail "photographs.csv: $(tail -n 1 comma/photographs.csv)"
awk -F , '{ $2 = "" } NR > 1 && NR < 15' digital/digital.csv >first.column
awk -F , '{ $2 = "" } NR > 14' digital/digital.csv >second.column
expect_same first.column second.column
mkdir twenty
for i in $(seq 0 4 76); do cp "$assets/frames/test/$(printf %03d "$i").npz" twenty; done
expect_exit 0 "the same photographs without a protocol" "$evaluate" --run run --frames twenty --output plainly
expect_figures_of_run plainly/metrics.csv digital/digital.csv
expect_exit 0 "the plain car in photographs" "$evaluate" --protocol digital --clean-only --quick --output plain_digital
grep -q 'was made with' plain_digital/digital.md && fail "a plain car that was optimised" || pass
[ "$(wc -l <plain_digital/digital.csv)" -eq 3 ] && pass || fail "more than the clean car and the photograph were measured"
expect_exit 2 "a background of photographs" "$evaluate" --protocol digital --clean-only --background 1 1 1
expect_error_line '^error: --background has no part in --protocol digital'
expect_exit 2 "a further detector without its description" "$evaluate" "${photographs[@]:0:6}" --further-weights "$assets/detector.weights"
expect_error_line '^error: --further-weights: .*detector.weights is not an .onnx model; convert_weights makes one'
expect_refusal 7 '--quick \(was true, now false\)' "other photographs" "$evaluate" "${photographs[@]}" --output digital

expect_exit 0 "draws of noise" "$evaluate" "${photographs[@]:0:6}" --quick --controls matched --noise-draws 3 --output drawn
grep -q '^  matched noise *[0-9]* of 60 ' command.out && grep -q 'draws that leave no more' command.out && grep -qE ' [0-3] of 3$' command.out &&
  pass || fail "no three draws: $(grep -m 1 'matched noise' command.out)"
for name in 'matched noise' 'matched noise 2' 'matched noise 3' 'picture noise'; do
  [ "$(grep -c "^detector,$name," drawn/photographs.csv)" -eq 20 ] && pass || fail "photographs.csv of $name"
done
grep '^detector,matched noise,' digital/photographs.csv >one.csv
grep '^detector,matched noise,' drawn/photographs.csv >first.csv
expect_same one.csv first.csv  # the first draw is that without the option
grep -q '^clean & .*\\\\$' drawn/digital.tex && pass || fail "no LaTeX: $(head -n 9 drawn/digital.tex)"
expect_exit 7 "another number of draws" "$evaluate" "${photographs[@]:0:6}" --quick --controls matched --noise-draws 2 --output drawn
expect_error_line '--noise-draws \(was 3, now 2\)'
expect_refusal 2 '^error: --noise-draws takes 1 to 1000' "no draws" "$evaluate" "${photographs[@]:0:6}" --noise-draws 0
expect_exit 2 "fewer draws than none" "$evaluate" "${photographs[@]:0:6}" --noise-draws -1
expect_error_line "^error: --noise-draws: expected a whole number of at least 0, found '-1'"
expect_refusal 2 '^error: --noise-draws needs --protocol: digital measures the same frames, ' "draws without a protocol" "$evaluate" --clean-only --noise-draws 2

expect_exit 0 "attention" "$evaluate" --protocol attention "${photographs[@]:2}" --controls matched --quick --output attention # of .onnx, see real_frames_test.sh
[ "$(grep -c '^attention on the car' command.out)" -eq 2 ] && pass || fail "not a table for each detector"
awk -F , 'NR > 1 && !($5 >= 0 && $5 <= 1) { exit 1 }' attention/photographs.csv && pass || fail "photographs.csv"
expect_exit 2 "heat maps where there are none" "$evaluate" "${photographs[@]}" --heat-map-kind grad_cam
expect_error_line '^error: --heat-map-kind has no part in --protocol digital'
expect_refusal 2 "--heat-map-kind is 'warm'" "heat maps of no kind" "$evaluate" --protocol attention --clean-only --heat-map-kind warm

# Stopped politely. (F15)
"$evaluate" --protocol occlusion "${small[@]}" --output stopped >/dev/null 2>stopped.err &
process=$!
wait_for 10 grep -q 'frame' stopped.err
stop INT "$process"
code=$?
if [ "$code" -eq 130 ]; then
  grep -q 'frames to go; the same command goes on' stopped.err && pass || fail "no word on how to go on"
  expect_file stopped/outcomes.npz
elif [ "$code" -ne 0 ]; then fail "SIGINT: exit code $code"; fi
expect_exit 0 "after the stop" "$evaluate" --protocol occlusion "${small[@]}" --output stopped
expect_same_report occlusion stopped whole
[ -e stopped/.lock ] && fail "the lock is left behind" || pass
grep -q '"instruction_set": "' whole/occlusion.json && grep -q ' on .*)\.' whole/occlusion.md && pass ||
  fail "the report does not say what computed it"

expect_exit 0 "the plain car" "$evaluate" --protocol occlusion --quick --clean-only --size 128 --output plain
grep -q 'worst cell: the plain car is found least at' command.out && pass || fail "no worst cell of the plain car"
[ "$(wc -l <plain/occlusion.csv)" -eq 27 ] && pass || fail "more than the plain car was measured"

# Other settings in the folder of a measurement. (F26)
expect_exit 7 "another seed" "$evaluate" --protocol occlusion "${small[@]}" --seed 2 --output whole
expect_error_line 'whole holds a measurement with other settings: --seed \(was 1, now 2\)'
expect_refusal 7 'protocol \(was "occlusion", now "views"\)' "another protocol" "$evaluate" --protocol views "${small[@]}" --output whole
expect_refusal 7 '--quick \(was true, now false\)' "all views" "$evaluate" --protocol occlusion "${small[@]:0:2}" "${small[@]:3}" --output whole
expect_exit 0 "another camouflage" "$programs/camouflage" --frames frames --texels 8 --epochs 1 --seed 2 --start random --output other
expect_exit 7 "the camouflage of another run" "$evaluate" --protocol occlusion --run other "${small[@]:2}" --output whole
expect_error_line 'inputs: other/manifest.json .*other/texture.npz'
expect_refusal 7 'run holds a run' "the folder of a run" "$evaluate" --protocol views "${small[@]}" --output run
cmp -s whole/occlusion.csv before.csv && pass || fail "a refused measurement changed the files"

# Damaged files of a measurement. (F27)
cp -r whole damaged
head -c 300 whole/outcomes.npz >damaged/outcomes.npz
expect_refusal 3 'damaged/outcomes.npz:@300: ' "cut outcomes" "$evaluate" --protocol occlusion "${small[@]}" --output damaged
cp two/outcomes.npz damaged/outcomes.npz
expect_exit 4 "outcomes of another measurement" "$evaluate" --protocol occlusion "${small[@]}" --output damaged
expect_error_line 'damaged/outcomes.npz: outcomes of another measurement; expected 216 frames of 6 textures'
printf '{"program": "evaluate"}' >damaged/settings.json
expect_exit 3 "settings that are none" "$evaluate" --protocol occlusion "${small[@]}" --output damaged
expect_error_line 'damaged/settings.json: not the settings of a measurement'

# Options that make no sense.
expect_exit 2 "an unknown protocol" "$evaluate" --protocol sideways --clean-only
expect_error_line "--protocol is 'sideways'; expected one of digital, physical, attention, views, occlusion, traffic"
expect_exit 2 "an unknown set of controls" "$evaluate" --protocol views --run run --controls some
expect_refusal 2 '^error: --background takes numbers from 0 to 1' "a colour that is none" "$evaluate" --protocol views --clean-only --background 2 0 0
expect_refusal 2 '^error: --frames has no part in --protocol' "frames" "$evaluate" --protocol views --clean-only --frames frames
expect_refusal 2 '^error: --light has no part in --protocol views' "light" "$evaluate" --protocol views --clean-only --light photo
expect_exit 2 "controls of nothing" "$evaluate" --protocol views --clean-only --controls all
expect_refusal 2 '^error: --quick needs --protocol' "quick without a protocol" "$evaluate" --clean-only --quick
expect_exit 2 "neither a run nor the plain car" "$evaluate" --protocol views
expect_refusal 2 '^error: --protocol has no part in --dataset' "a data set" "$evaluate" --protocol views --dataset frames
expect_exit 3 "no such run" "$evaluate" --protocol views --run absent --output none
expect_exit 4 "the texture of another layout" "$evaluate" --protocol views --run run --texels 16 --output none
[ -e none ] && fail "a refused measurement left a folder behind" || pass
touch file
expect_exit 5 "a file in the folder's place" "$evaluate" --protocol views "${small[@]}" --output file

finish
