#!/usr/bin/env bash
# Dependence of a run's bits on more than its options: the build, the folder where it began, and what it has written.
source "$(dirname "$0")/support.sh"
needs camouflage evaluate tabulate

mkdir -p project/frames project/car && cd project || exit 1
cp "$assets"/frames/test/00[01].npz frames
cp "$assets"/car_sedan.{obj,mtl} "$assets"/detector.{cfg,weights,names} car
brief=(--frames frames --mesh car/car_sedan.obj --material body --cfg car/detector.cfg --weights car/detector.weights
  --names car/detector.names --texels 8 --size 64 --threads 1)
on() { TAPESTRY_INSTRUCTION_SET=$1 "${@:2}"; } # SET COMMAND...
fact() { sed -n "s/^  \"$1\": \"\(.*\)\",\{0,1\}$/\1/p" "$2"; } # NAME FILE
states() { sed -i "s/^\(  \"$2\": \"\).*\(\",\{0,1\}\)$/\1$3\2/" "$1"; } # FILE NAME VALUE

# A run continues with its first instruction set, if this processor has it. (F12)
expect_exit 0 "a run" "$camouflage" "${brief[@]}" --epochs 40 --output best
best=$(fact instruction_set best/manifest.json)
expect_exit 0 "a run of the portable set" on portable "$camouflage" "${brief[@]}" --epochs 40 --output whole
TAPESTRY_INSTRUCTION_SET=portable "$camouflage" "${brief[@]}" --epochs 40 --checkpoint-steps 1 --output begun >/dev/null 2>&1 &
process=$!
wait_for 30 [ -e begun/checkpoint.npz ]
stop KILL "$process"
[ -e begun/metrics.json ] && fail "the run was over before it was killed" || pass
cp -r begun damaged
if [ "$best" != portable ]; then
  cmp -s best/texture.npz whole/texture.npz && fail "both instruction sets give the same bits" || pass
  expect_exit 7 "resumed with another set on purpose" on "$best" "$camouflage" --resume --output begun
  expect_error_line "^error: begun: cannot resume to the same bits: instruction_set \(was portable, now $best\); --accept-other-build"
fi
expect_exit 0 "resumed with whatever set" "$camouflage" --resume --output begun
expect_same_files begun whole texture.npz metrics.csv manifest.json
expect_exit 0 "measured" "$evaluate" --run whole --output whole_measured
expect_same whole_measured/metrics.csv whole/metrics.csv
grep -q '"instruction_set": "portable"' whole_measured/metrics.json && pass || fail "not measured by the run's instruction set"

# A set that this processor lacks, another compiler and another version are refused, unless they are accepted; then both stand
# in the manifest.
for other in instruction_set=avx1024 compiler=cc version="$(fact version best/manifest.json | sed 's/[0-9]*$/99/')"; do
  cp begun/manifest.json damaged && states damaged/manifest.json "${other%=*}" "${other#*=}"
  own=$(fact "${other%=*}" whole/manifest.json)
  [ "${other%=*}" != instruction_set ] || own=$best
  expect_exit 7 "resumed with another ${other%=*}" "$camouflage" --resume --output damaged
  expect_error_line "^error: damaged: cannot resume to the same bits: ${other%=*} \(was ${other#*=}, now $own\); --accept-other-build"
done
states damaged/manifest.json compiler cc
expect_exit 0 "another build that is accepted" "$camouflage" --resume --accept-other-build --output damaged
grep -q '^warning: damaged goes on by another build, whose bits may be others: .*compiler (was cc, now' command.err && pass || fail "no warning"
grep -A 9 '"resumed_by"' damaged/manifest.json | grep -q '"compiler"' && [ "$(fact compiler damaged/manifest.json)" = cc ] && pass ||
  fail "the manifest does not state both builds"
expect_exit 0 "its measurement" "$evaluate" --run damaged
grep -q '^warning: damaged was made by another build: .*compiler (was cc, now' command.err && pass || fail "measured without a word"

# So does a measurement.
protocol=(--protocol digital --quick --controls matched)
expect_exit 0 "a measurement" "$evaluate" --run begun "${protocol[@]}" --output measured
[ "$(fact instruction_set measured/settings.json)" = portable ] && pass || fail "the settings state no instruction set"
expect_exit 0 "the measurement goes on" "$evaluate" --run begun "${protocol[@]}" --output measured
if [ "$best" != portable ]; then
  expect_exit 7 "it goes on with another set" on "$best" "$evaluate" --run begun "${protocol[@]}" --output measured
  expect_error_line "measured holds a measurement with other settings: instruction_set \(was \"portable\", now \"$best\"\)"
  expect_exit 0 "a run of the best set" "$evaluate" --run best "${protocol[@]}" --output best_measured
  expect_exit 0 "both in a table" "$programs/tabulate" --output table one=measured two=best_measured
  grep -q "Not all of it was computed by one instruction set, .*$best (best_measured), portable (measured)" table/table.md && pass ||
    fail "the table does not name the instruction sets: $(grep -i 'instruction' table/table.md)"
fi

# The manifest lists the files that a run wrote; another paint in place of one is refused.
for file in texture.npz texture.png texture.json painted.obj painted.mtl painted.glb painted.png matched_noise.png result.png metrics.csv; do
  grep -q "\"$file\": \"$(sha256sum <"best/$file" | cut -d ' ' -f 1)\"" best/manifest.json && pass || fail "the manifest lacks $file"
done
cp -r best taken && cp whole/texture.npz taken
short() { sha256sum <"$1" | cut -c 1-16; }
hashes="taken/texture.npz \(expected SHA-256 $(short best/texture.npz), found SHA-256 $(short whole/texture.npz)\)"
for how in "" "--protocol digital --quick" "--protocol views --quick"; do
  # shellcheck disable=SC2086  # several words on purpose
  expect_refusal 7 "^error: taken: inputs have changed since the run: $hashes" "another paint $how" "$evaluate" --run taken $how --output none
done
expect_refusal 7 "$hashes" "against another paint" "$evaluate" --run best --against taken
expect_exit 0 "another paint on purpose" "$evaluate" --run taken --accept-changed-inputs --output accepted
grep -A 2 '"changed_inputs"' accepted/metrics.json | grep -q taken/texture.npz && pass || fail "metrics.json does not name the paint"
cp best/texture.npz taken && cp best/before.png taken/result.png
expect_exit 0 "another picture" "$evaluate" --run taken
grep -q '^warning: taken/result.png is not the file that the run wrote' command.err && pass || fail "nothing is said of another picture"
sed -i 's/"outputs"/"once"/' taken/manifest.json
expect_exit 0 "a run of an earlier version" "$evaluate" --run taken
grep -q '^warning: taken/manifest.json states no hashes of what the run wrote, so its paint was not compared$' command.err && pass ||
  fail "an old run is measured without a word"

# A run can be measured and resumed from anywhere, and moved, alone or with its inputs.
mkdir ../other ../other/frames && cp "$assets"/frames/test/002.npz ../other/frames/000.npz # a decoy
cd ../other || exit 1
measured_elsewhere() { # WHAT RUN
  rm -rf out
  expect_exit 0 "$1" "$evaluate" --run "$2" --output out
  expect_same out/metrics.csv ../whole.csv
  expect_same out/views.csv ../views.csv
}
cp ../project/best/metrics.csv ../whole.csv && cp ../project/best/views.csv ../views.csv
measured_elsewhere "measured from elsewhere" ../project/best
grep -q "^paths of the run start in .*/project$" command.out && pass || fail "nothing is said of the folder: $(cat command.out)"
cp -r ../project/best kept
expect_exit 0 "resumed from elsewhere" "$camouflage" --resume --output ../project/best
expect_same_files ../project/best kept texture.npz manifest.json
measured_elsewhere "a run that was moved alone" kept
mkdir own && cp ../project/frames/*.npz own
expect_exit 0 "frames of here" "$evaluate" --run ../project/best --frames own --output of_own
expect_same of_own/metrics.csv ../whole.csv
mv ../project ../moved
measured_elsewhere "moved with its inputs" ../moved/best
mv ../moved/car ../gone
expect_exit 3 "an input that is gone" "$evaluate" --run ../moved/best
expect_error_line '^error: car/car_sedan.obj: not there; it is --mesh of .*/best, which began in .*/project; give another by that option$'
expect_exit 3 "resumed without it" "$camouflage" --resume --output ../moved/best
expect_error_line '^error: car/car_sedan.obj: not there; it is --mesh of .*/best, which began in .*; put it there, or begin a new run$'
finish
