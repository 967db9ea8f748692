#!/usr/bin/env bash
# camouflage from the outside: a run's files, bits, resuming after any death, refusals.
source "$(dirname "$0")/support.sh"
needs camouflage
# Nearly all runs are measured on four frames, for a measurement takes longest.
mkdir "four frames" && cp "$assets"/frames/test/00[0-3].npz "four frames"
quick=(--frames "four frames" --scenes 40 --texels 32 --epochs 2 --checkpoint-steps 3)

expect_exit 0 "a short run" "$camouflage" "${quick[@]}" --threads 2 --output two
grep -Eq '^measuring blue: picture ([0-9]+) of \1, ' command.err && pass || fail "no word on how far the measurement is"
grep -q $'\r' command.err && fail "a line is rewritten where there is no terminal" || pass
for file in manifest.json history.csv texture.png matched_noise.png shuffled.png texture.npz painted.obj painted.glb \
  before.png after.png checkpoint.npz metrics.json metrics.csv views.csv report.html; do expect_file "two/$file"; done
for key in photo clean adversarial controls "matched noise" shuffled random blue mean_best_confidence asr effect beyond \
  seconds peak_mib seed options; do
  grep -q "\"$key\"" two/metrics.json && pass || fail "metrics.json lacks $key"
done

for fact in commit instruction_set processor compiler version; do
  grep -Eq "\"$fact\": \".+\"" two/manifest.json && pass || fail "the manifest lacks $fact"
  grep -Eq "\"$fact\": \".+\"" two/metrics.json && pass || fail "metrics.json lacks $fact"
done
set=$(sed -n 's/^  "instruction_set": "\(.*\)",$/\1/p' two/manifest.json)
grep -q "Tapestry [0-9.]* (.*$set on " two/report.html && pass || fail "the page does not say what computed it"

# The same rows in the same order everywhere, and the effect beyond matched noise under them.
rows="photo clean adversarial matched_noise shuffled random white grey black red green blue"
listed() { tr '\n' ' ' | sed 's/ $//'; }
[ "$(tail -n +2 two/metrics.csv | cut -d, -f1 | tr ' ' _ | listed)" = "$rows" ] && pass || fail "the rows of metrics.csv"
awk -F, 'NR > 1 && ($8 != $3 || $8 + $9 + $10 + $11 + $12 != $2)' two/metrics.csv >wrong.csv
[ -s wrong.csv ] && fail "fates do not add up: $(cat wrong.csv)" || pass
[ "$(sed -n 's/^  \(.*[^ ]\) *found in.*mean best confidence [01]\.[0-9]*$/\1/p' command.out | tr ' ' _ | listed)" = "$rows" ] &&
  pass || fail "the rows of the printed table"
[ "$(sed -n -e '/<summary>Inputs/,/<\/details>/d' -e 's/^<tr><td>\([^<]*\)<.*$/\1/p' two/report.html | tr ' ' _ | listed)" = "$rows" ] && pass || fail "the rows of report.html"
# Every table lies in a part of the page that scrolls.
[ "$(grep -c '<table' two/report.html)" = "$(grep -cE 'class="wide[^<]*><table' two/report.html)" ] && pass ||
  fail "a table that does not scroll"
effect='effect beyond matched noise: mean best confidence -?[0-9.]+ \[-?[0-9.]+, -?[0-9.]+\], P@0.5 -?[0-9.]+ points \[-?[0-9.]+, -?[0-9.]+\]'
for file in command.out two/report.html; do
  grep -Eq "$effect" "$file" && pass || fail "no effect beyond matched noise in $file"
done

# The verdict stands first in the page and in the output, and has the table's counts.
verdict=$(sed -n 's/^  "verdict": "\(.*\)",$/\1/p' two/metrics.json)
[ "$(grep -m 1 '^Found in\|^No verdict' command.out)" = "$verdict" ] && grep -qF "<p class=\"verdict\">$verdict</p>" two/report.html && pass ||
  fail "the verdict '$verdict' is not everywhere"
counts=$(awk -F, '{ found[$1] = $3 } END { print "Found in " found["adversarial"] " of " $2 " held-out views with the paint, " found["matched noise"] \
  " with noise of the same colours, " found["clean"] " plain: " }' two/metrics.csv)
case $verdict in "$counts"?*.) pass ;; *) fail "'$verdict' does not begin with '$counts'" ;; esac

expect_exit 0 "the same seed again, one thread" "$camouflage" "${quick[@]}" --threads 1 --output one
expect_same_files one two texture.npz history.csv metrics.csv views.csv

# Controls that are the same for every paint can be left out; all others stay.
expect_exit 0 "matched controls alone" "$camouflage" "${quick[@]}" --controls matched --output matched
expect_same matched/texture.npz two/texture.npz
expect_same matched/metrics.csv <(sed '/^\(random\|white\|grey\|black\|red\|green\|blue\),/d' two/metrics.csv)
expect_refusal 2 "--controls is 'few'; expected one of all, matched" "other controls" "$camouflage" "${quick[@]}" --controls few --output few

# Threads share a step view by view: they meet a few times, not at every layer, and memory is used again. On 2 threads a
# step waited 150 times when each layer was shared.
cost() { sed -nE "s/^[0-9.]+ s, [0-9]+ MiB at most, ([0-9]+) waits, ([0-9]+) page faults$/\\$1/p" command.err; }
counted=(--frames "four frames" --scenes 40 --texels 32 --checkpoint-steps 1000 --threads 2 --verbose)
for length in 2 52; do
  expect_exit 0 "a run of $length epochs" "$camouflage" "${counted[@]}" --epochs "$length" --output "long$length"
  cost 1 >"waits$length" && cost 2 >"faults$length"
done
steps=$(($(wc -l <long52/history.csv) - $(wc -l <long2/history.csv)))
[ "$steps" -ge 200 ] && pass || fail "$steps steps are too few to count by"
[ $((($(cat waits52) - $(cat waits2)) / steps)) -le 20 ] && pass || fail "waits of $steps steps: $(cat waits52) - $(cat waits2)"
[ $((($(cat faults52) - $(cat faults2)) / steps)) -le 60 ] && pass ||
  fail "page faults of $steps steps: $(cat faults52) - $(cat faults2)"

# A run first says what memory it will take, and that is what it takes; one that may not take as much does not begin.
foreseen() { sed -nE 's/^memory, MiB: .* together ([0-9]+); while measuring ([0-9]+).*/\1 \2/p' command.out | tr ' ' '\n' | sort -n | tail -n 1; }
peak() { sed -nE 's/^[0-9.]+ s, ([0-9]+) MiB at most.*/\1/p' command.err; }
for words in "" "--scenes 300 --texels 256" "--scenes 16 --texels 512" "--scenes 16 --texture cube --texels 8"; do
  # shellcheck disable=SC2086  # several words on purpose
  expect_exit 0 "memory of '$words'" "$camouflage" $words --epochs 1 --threads 2 --verbose --output held
  off=$(($(foreseen) - $(peak)))
  [ $((5 * ${off#-})) -le "$(peak)" ] && pass || fail "memory of '$words': $(foreseen) MiB foreseen, $(peak) taken"
  rm -rf held
done
expect_refusal 8 "^error: too little memory: the run needs [0-9]+ MiB and may take 600 .* of which [0-9]+ would fit$" \
  "too many texels" "$camouflage" --scenes 16 --texels 2048 --memory-mib 600 --threads 2 --output held
rows=$(sed -nE 's/^error: .*of which ([0-9]+) would fit$/\1/p' command.err)
[ ! -e held ] && [ "$rows" -ge 400 ] && pass || fail "a folder, or only $rows rows"
expect_exit 0 "$rows rows, as said" "$camouflage" --scenes 16 --texels "$rows" --memory-mib 600 --epochs 1 --threads 2 --output held
rm -r held
expect_refusal 8 "^error: too little memory: .* of which [0-9]+ would fit$" "cubes of 32" "$camouflage" --texture cube --texels 32 --output none

expect_exit 0 "evaluate gives the run's figures again" "$programs/evaluate" --run two --output again --film film.png --seconds 0.2
if command -v python3 >/dev/null; then  # four views; beside the network's input of 256 pixels, three columns have gaps of 4
  expect_exit 0 "the film" python3 "$sources/tests/programs/moving_picture.py" frames film.png 4 200
  [ "$(od -An -tu1 -j18 -N2 film.png | tr -s ' ')" = " 3 16" ] && pass || fail "film.png is not 3 * 260 + 4 pixels wide"
fi
expect_refusal 2 '--film takes a name that ends with .png' "a film of another kind" "$programs/evaluate" --run two --film film.gif
expect_exit 2 "a film of a protocol" "$programs/evaluate" --run two --protocol views --film no.png
expect_same_files again two metrics.csv views.csv
expect_exit 0 "evaluate without a camouflage" "$programs/evaluate" --clean-only --output plain
[ "$(tail -n +2 plain/metrics.csv | cut -d, -f1 | listed)" = "photo clean random white grey black red green blue" ] && pass ||
  fail "controls of nothing"
grep -q '"effect": null' plain/metrics.json && pass || fail "an effect of nothing"
# An ensemble of one detector twice has the detector's loss, with the same bits, as halves are exact.
expect_exit 0 "a second detector" "$programs/convert_weights" --cfg "$assets/detector.cfg" \
  --weights "$assets/detector.weights" --output second.onnx
expect_exit 0 "an ensemble" "$camouflage" "${quick[@]}" --ensemble second.onnx --output ensemble
expect_same ensemble/texture.npz two/texture.npz
grep -q '"ensemble"' ensemble/manifest.json && pass || fail "the manifest does not name the ensemble"
grep -q '"ensemble"' two/manifest.json && fail "a manifest names an ensemble that is not there" || pass
expect_refusal 2 "--ensemble: .*detector.weights is not an .onnx model; convert_weights makes one" "an ensemble that needs a cfg" "$camouflage" --ensemble "$assets/detector.weights" --output none
expect_exit 0 "a check" "$camouflage" --ensemble second.onnx --check
expect_exit 3 "an ensemble that is not there" "$camouflage" --ensemble none.onnx --check

expect_exit 0 "cubes have matched controls, too" "$camouflage" --scenes 20 --texture cube --texels 3 --epochs 1 --output cubes
grep -q '^matched noise,80,' cubes/metrics.csv && pass || fail "no matched noise of cubes"
# A page of all 80 views, some of them large: the photograph, the plain car, noise and the paint.
[ "$(wc -c <cubes/report.html)" -le 4000000 ] && pass || fail "the page of 80 views has $(wc -c <cubes/report.html) bytes"
jpegs=$(grep -o '/9j/4AAQ' cubes/report.html | wc -l)
[ "$jpegs" -ge 32 ] && [ $((jpegs % 4)) = 0 ] && pass || fail "$jpegs JPEGs in the page, not four a view"
expect_exit 0 "evaluate draws the run's scenes again" "$programs/evaluate" --run cubes --threads 1 --output cubes_again
expect_same_files cubes_again cubes metrics.csv views.csv
# Colours are blended in light, or as in the paper; older manifests mean the latter.
grep -q '"colour-space": "linear"' two/manifest.json && pass || fail "the manifest does not name the colour space"
expect_exit 0 "colours blended by their numbers" "$camouflage" "${quick[@]}" --colour-space encoded --output by_numbers
grep -q '"colour-space"' by_numbers/manifest.json && fail "a manifest names what was no choice before" || pass
if cmp -s by_numbers/texture.npz two/texture.npz; then fail "both colour spaces give the same texture"; else pass; fi
expect_exit 0 "an encoded run resumed" "$camouflage" --resume --output by_numbers
expect_refusal 7 '--colour-space \(was "encoded", now "linear"\)' "a run resumed in another colour space" "$camouflage" --resume --colour-space linear --output by_numbers
expect_exit 0 "an encoded run measured again" "$programs/evaluate" --run by_numbers --output measured_by_numbers
grep -q '"colour-space"' measured_by_numbers/metrics.json && fail "an encoded run was measured in light" || pass
# A frame without a mask gives its light only if the detector finds the car in its photograph.
expect_exit 0 "frames in parts" "$programs/make_dataset" --train 0 --test 4 --size 256 --occluded 0 --format png --output held
rm -r held/test/masks
look=("$programs/evaluate" --clean-only --confidence 0.1 --light)
expect_exit 0 "cars without masks" "${look[@]}" photo --frames held
cp -r held bare
expect_exit 0 "a picture of nothing" "$programs/render" --distance 5000 --size 256 --background 0.4 0.4 0.4 --output nothing.png
cp nothing.png bare/test/0001.png
expect_exit 0 "one frame without the car" "${look[@]}" photo --frames bare --output bare_run
grep -q '^warning: frame 0001 has no mask, and the detector finds no car where the mesh is' command.err && pass ||
  fail "no word on a frame without the car: $(cat command.err)"
grep -q 'in 1 view.s., such as 0001, there is no mask and the detector finds no car' bare_run/report.html && pass || fail "the report is silent on it"
for frame in 0 2 3; do cp nothing.png bare/test/000$frame.png; done
expect_refusal 4 '^error: --light photo: no photograph shows the car to the detector' "no frame with the car" "${look[@]}" photo --frames bare
expect_exit 0 "no frame with the car, in another light" "${look[@]}" frame --frames bare
expect_exit 0 "light estimated from photographs" "$camouflage" --frames "four frames" --scenes 4 --texels 32 --epochs 1 --light photo \
  --output by_photo
grep -q '"sky"' by_photo/light.json && pass || fail "the estimated light is not exported"
grep -q '"unpainted_faces_show": "the photograph"' by_photo/light.json && pass || fail "unpainted faces do not keep the photograph"
grep -q '"light": "photo"' by_photo/manifest.json && pass || fail "the manifest does not name the light"
[ -e two/light.json ] && fail "light is exported that was not estimated" || pass
expect_exit 2 "an unknown light" "$camouflage" --light moon --output none
expect_refusal 2 '--colour-space .*gamma' "an unknown colour space" "$camouflage" --colour-space gamma --output none

# An atlas is filtered, or looked up at single places; older manifests mean the latter.
grep -q '"filter": "anisotropic"' two/manifest.json && pass || fail "the manifest does not name the filter"
expect_exit 0 "single lookups" "$camouflage" "${quick[@]}" --filter bilinear --output unfiltered
grep -q '"filter"' unfiltered/manifest.json && fail "a manifest names what was no choice before" || pass
if cmp -s unfiltered/texture.npz two/texture.npz; then fail "both filters give the same texture"; else pass; fi
expect_exit 0 "an unfiltered run measured again" "$programs/evaluate" --run unfiltered --output measured_unfiltered
expect_refusal 2 '--filter .*cubic' "an unknown filter" "$camouflage" --filter cubic --output none

expect_exit 0 "another seed" "$camouflage" "${quick[@]}" --seed 2 --profile --output other
grep -Eq '^  layers kept of [0-9]+ of [0-9]+ views, where that saves 25 % of the products; ' command.out && pass ||
  fail "--profile does not say what is kept of layers"
grep -Eq '^  views  +[0-9.]+ s +[0-9.]+ s +[0-9.]+$' command.out && pass || fail "--profile does not say how many threads are busy"
if cmp -s other/texture.npz two/texture.npz; then fail "another seed gives the same texture"; else pass; fi

# Killed at a random moment and resumed, again and again, until it is through: the same bits, no torn file. (F01)
kills=8
[ "${TAPESTRY_TESTS_LONG:-}" != ON ] || kills=20
kill_until_done killed $kills 1 "$camouflage" "${quick[@]}"
expect_same_files killed two texture.npz history.csv

# Stopped by a signal: saves, prints the command that resumes, and resumes to the same bits. (F15)
long=(--frames "four frames" --scenes 40 --texels 32 --epochs 60 --checkpoint-steps 1000)
"$camouflage" "${long[@]}" --profile --output stopped >/dev/null 2>stopped.err &
process=$!
wait_for 10 [ -e stopped/manifest.json ]
sleep 1
stop INT "$process"
code=$?
if [ "$code" -eq 130 ]; then
  pass
  grep -q -- "--resume" stopped.err && pass || fail "no word on how to resume"
  grep -q -- '--output stopped .*--profile$' stopped.err && pass || fail "the command to resume is not the right one"
  expect_file stopped/checkpoint.npz
elif [ "$code" -eq 0 ]; then echo "the run was over before the signal"; else fail "SIGINT: exit code $code"; fi

for check in "" --check; do  # F11
  expect_refusal 7 'two already holds a run' "a folder that holds a run $check" "$camouflage" "${quick[@]}" --output two $check
done
expect_refusal 7 '\-\-seed \(was 1, now 9\)' "resume with another seed" "$camouflage" --seed 9 --resume --output two  # F12
expect_exit 3 "resume where nothing is" "$camouflage" --resume --output nowhere
expect_refusal 2 'did you mean --epochs' "a misspelt option" "$camouflage" --epoch 3
expect_exit 2 "an unknown loss" "$camouflage" --loss hinge
expect_exit 2 "a number that is none" "$camouflage" --epochs few
expect_refusal 3 'absent.obj' "a missing mesh" "$camouflage" --mesh absent.obj --material body --output absent
expect_exit 4 "a missing class" "$camouflage" --class unicorn --output absent
expect_refusal 4 'car_sedan.obj: .*paint' "a missing material" "$camouflage" --mesh "$sources/examples/assets/car_sedan.obj" --material paint --output absent
[ -e absent ] && fail "a refused run left a folder behind" || pass
touch file
expect_exit 5 "a file in the folder's place" "$camouflage" "${quick[@]}" --output file  # F09
mkdir frames && cp "$sources"/examples/assets/frames/test/*.npz frames
first=$(ls frames | head -n 1)
head -c 500 "frames/$first" >cut && mv cut "frames/$first"
expect_refusal 3 "frames/$first" "check with a cut frame" "$camouflage" --check --frames frames
printf '[net]\nwidth=64\n' >broken.cfg
expect_exit 3 "check with several problems" "$camouflage" --check --frames frames --cfg broken.cfg --weights absent.weights
if [ "$(grep -c '^error: ' command.err)" -ge 2 ]; then pass; else fail "--check does not list all problems"; fi
for output in broken.cfg/run /proc/none/run; do
  expect_refusal 5 "^error: $output: cannot create the folder: .*$" "check of $output" "$camouflage" --check --output "$output"
done
expect_exit 0 "check of sound inputs" "$camouflage" --check --output absent/run
[ -e absent ] && fail "a check made the folder" || pass
grep -Eq "the car is found as 'car' in [1-8] of 8 clean views" command.out && pass || fail "--check does not look for the car"
grep -Eq "^input of .*detector.weights: .* rgb, 0 to 1, mean 0, std 1, by Darknet's convention" command.err && pass ||
  fail "--check does not print how pictures go in"
expect_exit 0 "a car that is hardly found" "$camouflage" --check --confidence 0.994
grep -Eq "^warning: the car is found as 'car' in [1-3] of 8 clean views only: are --class, --detector and --confidence right\?$" command.err &&
  pass || fail "no warning of a car that is hardly found: $(cat command.err)"
expect_exit 4 "a class that is found in no view" "$camouflage" --check --class clutter  # X32
expect_error_line "the car is found as 'clutter' in none of 8 clean views, as 'car' in [1-8]"
expect_exit 0 "help" "$camouflage" --help

# From here on no scenes: a step takes a moment.
brief=(--frames "four frames" --texels 8)

# Values that make no sense are refused before anything is read or written. (T05, T14)
for words in "--epochs -1" "--epochs 18446744073709551615" "--batch -4" "--batch 0" "--scenes 10000000000" \
  "--texels 8193" "--texture cube --texels 500" "--keep-mib 18446744073709551615" "--keep-layers-mib 16777217" "--memory-mib 16777217" "--threads 1000000" \
  "--iou-weight nan" "--objectness-weight inf" "--smoothness-weight -1" "--printability nan" "--worst-views 0" "--worst-views 1.5" "--worst-views nan" \
  "--worst-views 0.5 --batch 1" "--seed 1.5" "--size 100000"; do
  # shellcheck disable=SC2086  # several words on purpose
  expect_exit 2 "$words" "$camouflage" $words --output senseless
  option=${words##*--}
  [ "$option" != "batch 1" ] || option="worst-views 0.5"
  expect_error_line "^error: --${option% *}"
done
expect_refusal 8 "^error: out of memory: more than 20 MiB are needed" "too little memory" "$camouflage" "${brief[@]}" --memory-mib 20 \
  --output little
expect_exit 2 "an empty name" "$camouflage" --mesh "" --output senseless
for words in "--material --output senseless" "--mesh --output senseless" "--class --resume" "--output --check"; do
  # shellcheck disable=SC2086  # several words on purpose
  expect_refusal 2 "^error: ${words%% *}: the value is missing before --" "$words" "$camouflage" $words
done
"$camouflage" --help >/dev/full 2>command.err
[ $? -eq 5 ] && pass || fail "help into a full standard output does not end with 5"
expect_exit 2 "check of several settings" "$camouflage" --check --texels 9999 --loss hinge --mask none --frames absent
[ "$(grep -c '^error: ' command.err)" -eq 4 ] && pass || fail "--check does not list settings and inputs together"
cp -r "four frames" cut_later && head -c 500 "four frames/003.npz" >cut_later/003.npz
expect_exit 3 "a cut frame after the first" "$camouflage" --frames cut_later --output senseless
[ -e senseless ] && fail "a refused run left a folder behind" || pass
expect_exit 0 "another car with the bundled frames" "$camouflage" --check --mesh "$assets/van.obj" --material body
grep -q '^warning: .*van.obj' command.err && pass || fail "no warning that the frames show another car"

# Printable colours, and steps that learn from their worst views alone: bits, resuming, refusals.
printf '# black, white, red\n0.1 0.1 0.1\n0.9,0.9,0.9\n0.8 0.2 0.2\n' >colours.txt
printable=("${brief[@]}" --epochs 20 --batch 4 --worst-views 0.5 --printability 10 --palette colours.txt --checkpoint-steps 2)
expect_exit 0 "printable colours" "$camouflage" "${printable[@]}" --threads 2 --output printable
expect_exit 0 "printable colours, one thread" "$camouflage" "${printable[@]}" --threads 1 --output printable1
kill_until_done printable2 2 1 "$camouflage" "${printable[@]}"
for other in printable1 printable2; do expect_same_files $other printable texture.npz history.csv manifest.json metrics.csv; done
grep -q '"palette": "colours.txt"' printable/manifest.json && grep -q '"worst-views": 0.5' printable/manifest.json && pass ||
  fail "the manifest does not name palette and worst views"
awk -F , 'NR == 1 && $7 != "printability" { exit 1 } NR == 2 { first = $7 } END { exit !(NR == 21 && $7 < first / 2) }' printable/history.csv && pass ||
  fail "the paint does not become printable: $(cut -d , -f 7 printable/history.csv)"
expect_exit 0 "the mean of all views" "$camouflage" "${brief[@]}" --epochs 20 --batch 4 --printability 10 --palette colours.txt --output mean
cmp -s mean/texture.npz printable/texture.npz && fail "worst views change nothing" || pass
echo '0.2 0.2 0.8' >>colours.txt
expect_refusal 7 'inputs have changed: colours.txt' "resumed with another palette" "$camouflage" --resume --output printable
expect_refusal 7 '--worst-views \(was 1(.0)?, now 0.25\)' "resumed with other worst views" "$camouflage" --resume --worst-views 0.25 --output mean
echo '0 128 255' >colours.txt
expect_refusal 3 '^error: colours.txt:1: a channel lies outside 0 to 1' "colours of bytes" "$camouflage" "${printable[@]}" --output senseless
expect_refusal 3 'none.txt' "a palette that is not there" "$camouflage" "${brief[@]}" --printability 1 --palette none.txt --check
expect_refusal 2 '^error: --palette needs --printability' "a palette for nothing" "$camouflage" "${brief[@]}" --palette colours.txt --output senseless
[ -e senseless ] && fail "a refused run left a folder behind" || pass

# Kept layers of a network change no bit.
expect_exit 0 "layers kept" "$camouflage" "${brief[@]}" --epochs 3 --output kept_layers
expect_exit 0 "layers not kept" "$camouflage" "${brief[@]}" --epochs 3 --keep-layers-mib 0 --output all_layers
cmp -s kept_layers/texture.npz all_layers/texture.npz && pass || fail "kept layers change the texture"

# Scenes to optimise on, frames to measure on.
expect_exit 0 "scenes and frames" "$camouflage" "${brief[@]}" --scenes 4 --epochs 1 --output both_kinds
grep -q '"held_out": true' both_kinds/metrics.json && pass || fail "the frames were not held out"
[ "$(grep -m1 -o '"views": [0-9]*' both_kinds/metrics.json)" = '"views": 4' ] && pass || fail "measured on other views"

# The colours of a mesh are an input, like the mesh.
mkdir own && cp "$assets"/car_sedan.{obj,mtl} own
cp "$assets"/detector.{cfg,weights,names} own
own=("${brief[@]}" --mesh own/car_sedan.obj --material body --cfg own/detector.cfg --weights own/detector.weights
  --names own/detector.names --epochs 1)
expect_exit 0 "a mesh of one's own" "$camouflage" "${own[@]}" --output own_mesh
expect_exit 0 "resumed" "$camouflage" --resume --output own_mesh
expect_exit 0 "measured again" "$programs/evaluate" --run own_mesh
echo '# another day' >>own/car_sedan.mtl
expect_refusal 7 'inputs have changed: own/car_sedan.mtl \(expected SHA-256 [0-9a-f]{16}, found SHA-256 [0-9a-f]{16}\)$' "resumed with other colours" "$camouflage" --resume --output own_mesh

# So is a measurement of the run, unless it names the other input.
expect_exit 7 "measured with other colours" "$programs/evaluate" --run own_mesh --output remeasured
expect_error_line '^error: own_mesh: inputs have changed since the run: own/car_sedan.mtl \(expected SHA-256 [0-9a-f]{16}, found SHA-256 [0-9a-f]{16}\);'
expect_refusal 7 'own_mesh: inputs have changed since the run: own/car_sedan.mtl' "a protocol with other colours" "$programs/evaluate" --protocol views --quick --run own_mesh --output remeasured
[ -e remeasured ] && fail "a refused measurement left a folder behind" || pass
expect_exit 0 "other colours on purpose" "$programs/evaluate" --run own_mesh --accept-changed-inputs --output remeasured
grep -q '^warning: own_mesh: inputs have changed since the run: own/car_sedan.mtl' command.err && pass || fail "no warning"
grep -A 2 '"changed_inputs"' remeasured/metrics.json | grep -q own/car_sedan.mtl && pass || fail "metrics.json does not name what has changed"
grep -q 'Inputs have changed since the run: own/car_sedan.mtl' remeasured/report.html && pass || fail "nor does the page"
# So is a measurement if the run to compare with has changed.
expect_exit 0 "a run after the change" "$camouflage" "${own[@]}" --output own_later
expect_refusal 7 '^error: own_mesh: inputs have changed since the run: own/car_sedan.mtl ' "against a run with other colours" "$programs/evaluate" --run own_later --against own_mesh
expect_exit 0 "against it on purpose" "$programs/evaluate" --run own_later --against own_mesh --accept-changed-inputs --output compared
grep -A 2 '"changed_inputs"' compared/metrics.json | grep -q own/car_sedan.mtl && pass || fail "metrics.json does not name what has changed"
expect_exit 0 "another mesh on purpose" "$programs/evaluate" --run own_mesh --mesh "$assets/car_sedan.obj"
mv own/car_sedan.mtl kept.mtl
expect_refusal 7 'own/car_sedan.mtl \(expected SHA-256 [0-9a-f]{16}, found none\)' "measured without colours" "$programs/evaluate" --run own_mesh
expect_exit 0 "a check without colours" "$camouflage" "${own[@]}" --check
grep -q "^warning: .*mtllib 'car_sedan.mtl' is not there" command.err && ! grep -q 'are sound' command.out && pass ||
  fail "--check says nothing of a missing MTL"
cp "$assets/car_sedan.mtl" own
printf '\1' | dd of=own/detector.weights bs=1 seek=100000 conv=notrunc status=none
expect_refusal 7 'inputs have changed since the run: own/detector.weights \(' "measured with other weights" "$programs/evaluate" --run own_mesh
expect_exit 0 "other weights on purpose" "$programs/evaluate" --run own_mesh --weights "$assets/detector.weights"
cp "$assets/detector.weights" own
cp "four frames/000.npz" "four frames/004.npz"
expect_refusal 7 'four frames/004.npz \(expected none, found SHA-256' "measured on one more frame" "$programs/evaluate" --run own_mesh
expect_exit 7 "a protocol with one more frame" "$programs/evaluate" --protocol digital --run own_mesh
mv "four frames/004.npz" "four frames/003.npz"
expect_refusal 7 'inputs have changed since the run: four frames/003.npz \(' "measured on another frame" "$programs/evaluate" --run own_mesh
expect_exit 0 "other frames on purpose" "$programs/evaluate" --run own_mesh --frames "$assets/frames"
cp "$assets/frames/test/003.npz" "four frames"
expect_exit 0 "everything as it was" "$programs/evaluate" --run own_mesh
expect_exit 2 "changes of nothing" "$programs/evaluate" --clean-only --accept-changed-inputs

# Failures on the way leave a run that can be resumed.
(
  ulimit -f 16 # KiB a file (F06)
  exec "$camouflage" "${brief[@]}" --epochs 2 --output limited >command.out 2>command.err
)
[ $? -eq 5 ] && pass || fail "a file that cannot be written whole does not end with 5"
expect_error_line 'limited/.*cannot write'
expect_exit 0 "resumed with more room" "$camouflage" --epochs 0 --resume --output limited
expect_file limited/metrics.json
ls -A limited | grep -q part && fail "a temporary file was left behind" || pass
expect_refusal 6 'step 1: term total is inf' "a loss that overflows" "$camouflage" "${brief[@]}" --max-score-weight 1e308 --output overflow  # T01
"$camouflage" "${brief[@]}" --epochs 1 --output unheard >/dev/full 2>command.err
[ $? -eq 5 ] && pass || fail "a full standard output does not end with 5"  # F05
expect_file unheard/metrics.json
"$camouflage" "${brief[@]}" --epochs 100000 --checkpoint-steps 1 --output no_streams >&- 2>&- <&- &  # F22
process=$!
wait_for 10 [ -e no_streams/checkpoint.npz ]
stop KILL "$process"
[ "$(wc -l <no_streams/.lock)" -eq 1 ] && pass || fail "what was printed went into a file"
expect_exit 0 "the run of a killed process" "$camouflage" --resume --epochs 100000 --output no_streams --check

# Refusals to resume name the cause.
cp -r limited damaged && sed 's/"mesh": "[^"]*"/"mesh": 3/' limited/manifest.json >damaged/manifest.json
expect_refusal 3 "damaged/manifest.json: no sound setting 'mesh'" "a manifest of another shape" "$camouflage" --resume --output damaged
expect_exit 3 "evaluate with it" "$programs/evaluate" --run damaged
sed 's/"worst-views"/"best-views"/' limited/manifest.json >damaged/manifest.json
expect_refusal 3 "damaged/manifest.json: no sound setting 'worst-views'.*a run that this version began" "a manifest of an earlier version" "$camouflage" --resume --output damaged
sed 's/"samples": [0-9]*/"samples": 2.5/' limited/manifest.json >damaged/manifest.json
expect_refusal 3 "damaged/manifest.json: no sound setting 'samples'" "a count with a fraction" "$programs/evaluate" --run damaged
nested=$(head -c 200000 /dev/zero | tr '\0' '[')$(head -c 200000 /dev/zero | tr '\0' ']')
printf '{"options": {"x": %s}, "inputs": []}' "$nested" >damaged/manifest.json
expect_refusal 3 'damaged/manifest.json:1:81: JSON nested too deep' "evaluate with a manifest nested 200,000 deep" "$programs/evaluate" --run damaged
expect_refusal 3 'damaged/manifest.json:1:81: JSON nested too deep' "resume with it" "$camouflage" --resume --output damaged
for foreign in 's/"program": "camouflage"/"program": "other"/' 's/"version": "[^"]*"/"version": "9.9.9"/'; do # N22
  sed "$foreign" limited/manifest.json >damaged/manifest.json
  expect_refusal 4 'damaged/manifest.json: the run of another (program|version); expected .*, found ' "measuring the run of another program or version" "$programs/evaluate" --run damaged
  expect_exit 4 "resuming it" "$camouflage" --resume --output damaged
done

# A path without access is unreadable input, or output that cannot be written.
ln -s loop loop
long=$(printf 'n%.0s' $(seq 300))
for name in loop "$long"; do
  expect_exit 3 "frames that cannot be inspected" "$camouflage" --check --frames "$name"
  expect_refusal 5 "^error: $name.*: cannot inspect" "a folder that cannot be inspected" "$camouflage" "${brief[@]}" --output "$name"
  expect_exit 3 "a run that cannot be inspected" "$camouflage" --resume --output "$name"
  expect_exit 3 "weights that cannot be inspected" "$camouflage" --check --cfg "$assets/detector.cfg" --weights "$name"
done

# The next process removes a killed one's temporaries; a signal that was ignored at the start stays ignored.
touch limited/checkpoint.npz.tapestry-part99999-0
expect_exit 0 "resumed after a kill" "$camouflage" --resume --output limited
ls -A limited | grep -q part && fail "what a killed process left is still there" || pass
(
  trap '' HUP INT
  exec "$camouflage" "${brief[@]}" --epochs 100 --output ignoring >/dev/null 2>&1
) &
process=$!
wait_for 10 [ -e ignoring/manifest.json ]
kill -HUP "$process"
stop INT "$process"
[ $? -eq 0 ] && pass || fail "a run under nohup ends with its terminal"
expect_file ignoring/metrics.json
rm "four frames/003.npz"
expect_refusal 7 'inputs have changed: four frames/003.npz' "an input that is gone" "$camouflage" --resume --output limited
expect_exit 7 "evaluate into a run's folder" "$programs/evaluate" --run both_kinds --output both_kinds

# Two at once: one of them runs. Without --output each gets a folder of its own.
"$camouflage" "${brief[@]}" --epochs 9 --output twice >/dev/null 2>&1 &
process=$!
"$camouflage" "${brief[@]}" --epochs 9 --output twice >/dev/null 2>&1
codes=$?
wait "$process"
codes=$((codes + $?))
[ "$codes" -eq 7 ] && pass || fail "two runs in one folder: exit codes add up to $codes, expected 0 and 7"
"$camouflage" "${brief[@]}" --epochs 1 >/dev/null 2>&1 &
process=$!
expect_exit 0 "a folder of its own" "$camouflage" "${brief[@]}" --epochs 1
wait "$process"
[ $? -eq 0 ] && [ -e runs/camouflage-001/metrics.json ] && [ -e runs/camouflage-002/metrics.json ] && pass ||
  fail "two runs without --output got in each other's way"

# A signal ends the preparation at once, and the command to go on can be pasted. (F17)
"$camouflage" --scenes 5000 --output unprepared >/dev/null 2>&1 &
process=$!
sleep 0.5
stop TERM "$process"
[ $? -eq 143 ] && [ ! -e unprepared ] && pass || fail "SIGTERM while scenes are drawn"
name=$'it\'s a \e[31mfolder\u202e'
"$camouflage" "${brief[@]}" --epochs 100000 --threads 2 --output "$name" >/dev/null 2>stopped.err &
process=$!
wait_for 10 [ -e "$name/manifest.json" ]
stop INT "$process"
eval "exec_resumed() { exec $(tail -n 1 stopped.err); }"
(exec_resumed >/dev/null 2>resumed.err) &
process=$!
sleep 1
stop INT "$process"
[ $? -eq 130 ] && grep -q 'saved after step' resumed.err && pass || fail "the resume command does not work when pasted"
grep -q $'\e\|\u202e' stopped.err && fail "a terminal takes orders from a name" || pass
[ -e "$name/.lock" ] && fail "the lock is left behind" || pass

# A hang-up, and the signals that batch queues send before the time is up, perhaps again. (F15)
for signal in HUP USR1 XCPU; do
  "$camouflage" "${brief[@]}" --epochs 100000 --output "by_$signal" >/dev/null 2>stopped.err &
  process=$!
  wait_for 10 [ -e "by_$signal/manifest.json" ]
  kill "-$signal" "$process"
  [ "$signal" = HUP ] || kill "-$signal" "$process"
  wait "$process"
  code=$?
  [ "$code" -eq $((128 + $(kill -l "$signal"))) ] && pass || fail "SIG$signal: exit code $code"
  expect_file "by_$signal/checkpoint.npz"
done
mkdir $'fr\xffames' && cp "four frames/000.npz" $'fr\xffames'
expect_exit 2 "frames whose name is not UTF-8" "$camouflage" --frames $'fr\xffames' --texels 8 --epochs 1 --output not_utf8
LC_ALL=C expect_error_line 'ames: the name is not UTF-8'
finish
