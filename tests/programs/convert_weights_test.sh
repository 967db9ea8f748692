#!/usr/bin/env bash
# convert_weights from the outside, and the programs that take what it writes.
source "$(dirname "$0")/support.sh"
convert=$programs/convert_weights
detect=$programs/detect
assets=$sources/examples/assets
[ -x "$convert" ] && [ -x "$detect" ] && [ -e "$assets/detector.weights" ] || exit 77
frame=$(ls "$assets"/frames/test/*.npz | head -n 1)
cfg=(--cfg "$assets/detector.cfg")
weights=(--weights "$assets/detector.weights")

# With nothing to be found in PATH: no Python and no other tool takes part.
expect_exit 0 "keeping batch normalisation" env PATH=/nonexistent "$convert" "${cfg[@]}" "${weights[@]}" --output kept.safetensors
grep -q 'batch normalisation kept, decode darknet' command.out && pass || fail "no summary"
grep -q "cfg sha256 $(sha256sum <"$assets/detector.cfg" | cut -d' ' -f1)" command.out && pass || fail "another hash of the cfg"
expect_exit 0 "folding" "$convert" "${cfg[@]}" "${weights[@]}" --fold --output folded.safetensors
expect_exit 0 "again" "$convert" "${cfg[@]}" "${weights[@]}" --output again.safetensors
expect_same kept.safetensors again.safetensors
[ "$(stat -c %s folded.safetensors)" -lt "$(stat -c %s kept.safetensors)" ] && pass || fail "folding saved nothing"

# The numbers are those behind the 20 bytes of the Darknet header, to the bit.
tail -c +21 "$assets/detector.weights" >numbers
tail -c "$(stat -c %s numbers)" kept.safetensors >kept.numbers
expect_same numbers kept.numbers

expect_exit 0 "detecting with Darknet weights" "$detect" --json "${cfg[@]}" "${weights[@]}" "$frame"
cp command.out darknet.json
expect_exit 0 "detecting with the converted ones" "$detect" --json "${cfg[@]}" --weights kept.safetensors "$frame"
expect_same darknet.json command.out
expect_exit 0 "detecting with the folded ones" "$detect" --json "${cfg[@]}" --weights folded.safetensors "$frame"
expect_same darknet.json command.out
cp kept.safetensors renamed
expect_exit 0 "under another name" "$detect" --json "${cfg[@]}" --weights renamed "$frame"
expect_same darknet.json command.out
sed 's/"decode":"darknet"/"decode":"scaled!"/' kept.safetensors >scaled.safetensors
expect_exit 4 "another decode family" "$detect" "${cfg[@]}" --weights scaled.safetensors "$frame"
expect_error_line "decode' is not supported; expected darknet, found 'scaled!'"
sed 's/"decode":"darknet"/"edoced":"darknet"/' kept.safetensors >silent.safetensors
expect_exit 4 "no decode family" "$detect" "${cfg[@]}" --weights silent.safetensors "$frame"
expect_error_line "decode' is missing"
head -c 50000 kept.safetensors >cut.safetensors
expect_exit 3 "a cut file" "$detect" "${cfg[@]}" --weights cut.safetensors "$frame"
expect_error_line 'cut.safetensors:@[0-9]+: tensor .* pass the end of the file'

train="$programs/train_detector --steps 0 --validate 1"
expect_exit 0 "training from a converted file" $train --weights kept.safetensors
expect_exit 4 "training from a folded one" $train --weights folded.safetensors
expect_error_line 'folded.safetensors: batch normalisation is folded'

expect_exit 2 "nothing given" "$convert"
expect_exit 2 "an unknown decode family" "$convert" "${cfg[@]}" "${weights[@]}" --decode ultralytics --output no
expect_error_line 'darknet'
expect_exit 2 "no epsilon" "$convert" "${cfg[@]}" "${weights[@]}" --batch-norm-epsilon 0 --output no
cp "$assets/detector.weights" mine.weights
expect_exit 2 "overwriting the input" "$convert" "${cfg[@]}" --weights mine.weights --output ./mine.weights
expect_same "$assets/detector.weights" mine.weights
expect_exit 3 "missing weights" "$convert" "${cfg[@]}" --weights absent.weights --output no
expect_error_line 'absent.weights'
head -c 5000 mine.weights >cut.weights
expect_exit 3 "cut weights" "$convert" "${cfg[@]}" --weights cut.weights --output no
expect_exit 3 "converted already" "$convert" "${cfg[@]}" --weights kept.safetensors --output no
expect_error_line 'safetensors file'
head -c 4096 /dev/zero | cat mine.weights - >longer.weights
expect_exit 4 "weights of another cfg" "$convert" "${cfg[@]}" --weights longer.weights --output no
expect_exit 5 "a missing folder" "$convert" "${cfg[@]}" "${weights[@]}" --output absent/x.safetensors
expect_error_line 'absent/x.safetensors'
[ -e no ] && fail "a refused conversion left a file" || pass
finish
