#!/usr/bin/env bash
# convert_weights from the outside, and the programs that read its files.
source "$(dirname "$0")/support.sh"
needs convert_weights detect
frame=$(ls "$assets"/frames/test/*.npz | head -n 1)
cfg=(--cfg "$assets/detector.cfg")
weights=(--weights "$assets/detector.weights")

# With an empty PATH: no Python and no other tool takes part.
expect_exit 0 "keeping batch normalisation" env PATH=/nonexistent "$convert_weights" "${cfg[@]}" "${weights[@]}" --output kept.onnx
grep -q 'batch normalisation kept, decode darknet' command.out && pass || fail "no summary"
grep -q "cfg sha256 $(sha256sum <"$assets/detector.cfg" | cut -d' ' -f1)" command.out && pass || fail "another hash of the cfg"
expect_exit 0 "folding" "$convert_weights" "${cfg[@]}" "${weights[@]}" --fold --output folded.onnx
expect_exit 0 "again" "$convert_weights" "${cfg[@]}" "${weights[@]}" --output again.onnx
expect_same kept.onnx again.onnx
[ "$(stat -c %s folded.onnx)" -lt "$(stat -c %s kept.onnx)" ] && pass || fail "folding saved nothing"

# A limit on the size of files is an error like a full disk; the old file stays, and nothing beside it.
cp kept.onnx limited.onnx
(
  ulimit -f 16 # KiB a file
  exec "$convert_weights" "${cfg[@]}" "${weights[@]}" --fold --output limited.onnx >command.out 2>command.err
)
[ $? -eq 5 ] && pass || fail "a file that cannot be written whole does not end with 5"
expect_error_line 'limited.onnx: cannot write'
expect_same kept.onnx limited.onnx
ls | grep -q part && fail "a temporary file was left behind" || pass

expect_exit 0 "detecting with Darknet weights" "$detect" --json "${cfg[@]}" "${weights[@]}" "$frame"
cp command.out darknet.json
expect_exit 0 "detecting with the converted ones" "$detect" --json "${cfg[@]}" --weights kept.onnx "$frame"
expect_same darknet.json command.out
expect_exit 0 "detecting with the folded ones" "$detect" --json "${cfg[@]}" --weights folded.onnx "$frame"
expect_same darknet.json command.out
sed 's/darknet/scaled!/' kept.onnx >unknown.onnx
expect_refusal 4 "decode' is not supported; expected darknet, ultralytics or scaled, found 'scaled!'" "an unknown decode family" "$detect" "${cfg[@]}" --weights unknown.onnx "$frame"
head -c 50000 kept.onnx >cut.onnx
expect_refusal 3 'cut.onnx' "a cut file" "$detect" "${cfg[@]}" --weights cut.onnx "$frame"

# The decode family goes with the file; another one is one error, also from a cfg.
expect_exit 0 "an ultralytics detector" "$convert_weights" "${cfg[@]}" "${weights[@]}" --decode ultralytics --output ultralytics.onnx
grep -q 'decode ultralytics' command.out && pass || fail "no word on the decode family"
expect_exit 0 "detecting with it" "$detect" --json --weights ultralytics.onnx "$frame"
cp command.out ultralytics_seen.txt
cmp -s darknet.json ultralytics_seen.txt && fail "the decode family changes nothing" || pass
expect_exit 0 "the same from Darknet weights" "$detect" --json --decode ultralytics "${cfg[@]}" "${weights[@]}" "$frame"
expect_same ultralytics_seen.txt command.out
expect_exit 0 "saying it again" "$detect" --json --decode ultralytics --weights ultralytics.onnx "$frame"
expect_same ultralytics_seen.txt command.out
expect_refusal 4 'ultralytics.onnx: is of the decode family ultralytics, which contradicts the requested darknet' "saying otherwise" "$detect" --decode darknet --weights ultralytics.onnx "$frame"
expect_refusal 2 "--decode is 'yolov5'; expected one of darknet, ultralytics, scaled" "asking for an unknown family" "$detect" --decode yolov5 "${cfg[@]}" "${weights[@]}" "$frame"

# Logistic activations before each head: scaled, and with s = 2 the boxes of ultralytics, found but not painted against.
awk '/^activation=/ { held = $0; next } /^\[yolo\]/ && held { held = "activation=logistic" }
     { if (held && /^\[/) { print held; held = "" } print }
     /^\[yolo\]/ { print "new_coords=1"; print "scale_x_y=2" }' "$assets/detector.cfg" >scaled.cfg
scaled=(--cfg scaled.cfg "${weights[@]}")
expect_exit 0 "detecting with new_coords=1" "$detect" "${scaled[@]}" "$frame"
grep -v ' ms an image' command.out >scaled.table
grep -q '^warning' command.err && fail "a warning without a cause" || pass
expect_exit 0 "detecting with ultralytics" "$detect" "${weights[@]}" "${cfg[@]}" --decode ultralytics "$frame"
grep -v ' ms an image' command.out >ultralytics.table
expect_same ultralytics.table scaled.table
expect_refusal 4 'scaled.cfg:[0-9]+: .*new_coords=1 contradicts the requested decode family; expected scaled, found ultralytics' "contradicting new_coords=1" "$detect" "${scaled[@]}" --decode ultralytics "$frame"
expect_exit 0 "converting new_coords=1" "$convert_weights" "${scaled[@]}" --output scaled.onnx
grep -q 'decode scaled' command.out && pass || fail "no word on the decode family"
expect_exit 0 "detecting with that" "$detect" --weights scaled.onnx "$frame"
grep -v ' ms an image' command.out >converted.table
expect_same scaled.table converted.table

# A file of an earlier release: one layer of 18 filters, of zeros.
text='[net]\nwidth=32\nheight=32\nchannels=3\n[convolutional]\nfilters=18\nsize=1\nactivation=linear\n'
text+='[yolo]\nmask=0,1,2\nanchors=1,1, 2,2, 3,3\nclasses=1\nnum=3\n'
header='{"__metadata__":{"batch_norm":"kept","batch_norm_epsilon":"1e-05","cfg":"'$text'","cfg_sha256":"'
header+=$(printf "$text" | sha256sum | cut -d' ' -f1)'","decode":"darknet","format":"tapestry-detector","images_seen":"7"},'
header+='"layers.0.bias":{"data_offsets":[0,72],"dtype":"F32","shape":[18]},'
header+='"layers.0.weight":{"data_offsets":[72,288],"dtype":"F32","shape":[18,3,1,1]}}'
{ printf "\\x$(printf %x $((${#header} % 256)))\\x$(printf %x $((${#header} / 256)))\0\0\0\0\0\0%s" "$header" && head -c 288 /dev/zero; } >old.safetensors
expect_refusal 3 'old.safetensors:@0: not a detector; .* found a safetensors file; convert_weights makes an ONNX model of' "detecting with a file of an earlier release" "$detect" --weights old.safetensors "$frame"
expect_exit 0 "converting it" "$convert_weights" --weights old.safetensors --output old.onnx
grep -q 'batch normalisation kept, decode darknet' command.out && pass || fail "no summary"
printf "$text" >old.cfg
{ printf '\0\0\0\0\2\0\0\0\5\0\0\0\7\0\0\0\0\0\0\0' && head -c 288 /dev/zero; } >old.weights
expect_exit 0 "converting the same weights" "$convert_weights" --cfg old.cfg --weights old.weights --output new.onnx
expect_same old.onnx new.onnx
expect_refusal 2 '^error: --cfg is for Darknet weights; old.safetensors states its own' "a cfg beside it" "$convert_weights" --cfg old.cfg --weights old.safetensors --output no.onnx
head -c -4 old.safetensors >cut.safetensors
expect_refusal 4 'cut.safetensors: another size than that of its tensors' "converting a cut one" "$convert_weights" --weights cut.safetensors --output no.onnx
expect_refusal 2 '^error: --output no.safetensors must end in .onnx' "writing one" "$convert_weights" "${cfg[@]}" "${weights[@]}" --output no.safetensors

# The cfg within is used when none is given, and no other file holds one.
expect_exit 0 "detecting without a cfg" "$detect" --json --weights kept.onnx "$frame"
expect_same darknet.json command.out
expect_exit 0 "detecting with a folded one, without a cfg" "$detect" --json --weights folded.onnx "$frame"
expect_same darknet.json command.out
grep -q '^warning' command.err && fail "a warning without a cause" || pass
sed 's/^\[net\]/# another\n[net]/' "$assets/detector.cfg" >another.cfg
expect_exit 0 "another cfg beside it" "$detect" --json --cfg another.cfg --weights kept.onnx "$frame"
grep -q '^warning: another.cfg: differs from the cfg inside kept.onnx' command.err && pass || fail "no warning"
expect_refusal 2 '^error: --cfg is missing, which .*detector.weights needs' "Darknet weights alone" "$detect" --weights "$assets/detector.weights" "$frame"
expect_refusal 2 '^error: --cfg and --weights go together; --weights is missing' "a cfg alone" "$detect" --cfg "$assets/detector.cfg" "$frame"
expect_refusal 3 'absent.onnx: cannot open' "a file that is not there" "$detect" --weights absent.onnx "$frame"

evaluate=$programs/evaluate
mkdir frames && cp "$frame" frames
with=(--frames frames --names "$assets/detector.names")
expect_exit 0 "measuring the Darknet detector" "$evaluate" --clean-only --sweep 0.25 "${with[@]}" "${cfg[@]}" "${weights[@]}"
cp command.out darknet.rows
expect_exit 0 "measuring the converted one" "$evaluate" --clean-only --sweep 0.25 "${with[@]}" --weights kept.onnx
expect_same darknet.rows command.out
expect_refusal 2 '^error: --cfg is missing' "measuring with Darknet weights alone" "$evaluate" --clean-only "${with[@]}" "${weights[@]}"

expect_exit 0 "measuring a scaled detector" "$evaluate" --clean-only "${with[@]}" --weights scaled.onnx

camouflage=$programs/camouflage
brief=("${with[@]}" --texels 8 --epochs 1)
expect_exit 0 "painting against the Darknet detector" "$camouflage" "${brief[@]}" "${cfg[@]}" "${weights[@]}" --output darknet
expect_exit 0 "painting against the converted one" "$camouflage" "${brief[@]}" --weights kept.onnx --output converted
expect_same darknet/texture.npz converted/texture.npz
grep -q '"path": "kept.onnx"' converted/manifest.json && pass || fail "the manifest lacks the detector"
expect_exit 0 "measuring that again" "$evaluate" --run converted --sweep 0.25
expect_exit 0 "measuring with another detector" "$evaluate" --run darknet --sweep 0.25 --names "$assets/detector.names" \
  --weights folded.onnx
grep -q '^warning' command.err && fail "the run's cfg was kept beside a converted detector" || pass
expect_exit 0 "resuming a run that is over" "$camouflage" --resume --output converted
cp folded.onnx kept.copy && cp kept.onnx mine.onnx
expect_exit 0 "a run of one's own" "$camouflage" "${brief[@]}" --weights mine.onnx --output own
cp kept.copy mine.onnx
expect_refusal 7 'inputs have changed: mine.onnx' "resuming with another detector" "$camouflage" --resume --output own
expect_exit 0 "checking a converted detector" "$camouflage" --check "${brief[@]}" --weights kept.onnx
expect_refusal 2 '^error: --cfg is missing' "checking Darknet weights alone" "$camouflage" --check "${brief[@]}" "${weights[@]}"
expect_refusal 3 'absent.onnx' "checking weights that are not there" "$camouflage" --check "${brief[@]}" --weights absent.onnx
expect_refusal 2 'camouflage: heads of the decode family scaled .* losses need raw logits' "painting against a scaled detector" "$camouflage" "${brief[@]}" --weights scaled.onnx --output no
expect_refusal 2 'camouflage: heads of the decode family scaled' "checking a scaled detector" "$camouflage" --check "${brief[@]}" --weights scaled.onnx
expect_exit 0 "painting against an ultralytics detector" "$camouflage" "${brief[@]}" --decode ultralytics "${cfg[@]}" \
  "${weights[@]}" --output other
grep -q '"decode": "ultralytics"' other/manifest.json && pass || fail "the manifest lacks the decode family"
expect_refusal 7 'decode .was .ultralytics., now .darknet' "resuming with another decode family" "$camouflage" --resume --decode darknet --output other
expect_exit 0 "measuring that run" "$evaluate" --run other
grep -q '"decode"' darknet/manifest.json && fail "a choice that was not made" || pass
expect_refusal 2 '^error: --cfg is missing' "painting against Darknet weights alone" "$camouflage" "${brief[@]}" "${weights[@]}" --output no

train="$programs/train_detector --steps 0 --validate 1"
expect_exit 0 "training from a converted file" $train --weights kept.onnx
expect_refusal 4 'folded.onnx: batch normalisation is folded' "training from a folded one" $train --weights folded.onnx  # W21
expect_refusal 2 'heads of the decode family scaled' "training a scaled one" $train --weights scaled.onnx
expect_refusal 2 '^error: --output no would lose the decode family ultralytics' "a form that would lose the decode family" $train "${cfg[@]}" --weights ultralytics.onnx --output no

# Another network than the bundled one, which the bundled cfg does not fit.
sed '0,/^filters=8$/s//filters=6/' "$assets/detector.cfg" >narrow.cfg
narrow="$programs/train_detector --steps 2 --batch 2 --fresh 1 --pool 4 --validate 1"
expect_exit 0 "random weights, converted at once" $narrow --cfg narrow.cfg --output narrow.onnx
expect_exit 0 "random weights, Darknet's" $narrow --cfg narrow.cfg --output narrow.weights
expect_exit 0 "these converted" "$convert_weights" --cfg narrow.cfg --weights narrow.weights --output same.onnx
expect_same narrow.onnx same.onnx
expect_exit 0 "going on from the file alone" $narrow --weights narrow.onnx
expect_file detector.onnx
expect_exit 0 "detecting with the outcome" "$detect" --weights detector.onnx "$frame"
expect_exit 0 "going on with the cfg" $narrow --cfg narrow.cfg --weights narrow.onnx --output on.weights
expect_exit 0 "that converted" "$convert_weights" --cfg narrow.cfg --weights on.weights --output on.onnx
expect_same detector.onnx on.onnx
expect_refusal 2 '^error: --output lost.weights would lose the cfg, which is only within narrow.onnx' "a form that would lose the cfg" $narrow --weights narrow.onnx --output lost.weights
[ -e lost.weights ] && fail "refused, and yet written" || pass

# The network as operators, for other tools.
expect_exit 0 "an ONNX model" "$convert_weights" "${cfg[@]}" "${weights[@]}" --output detector.onnx
grep -q 'detector.onnx: [0-9]* nodes, from "picture", \[1, 3, ' command.out && pass || fail "no summary of the model"
[ "$(grep -c 'raw logits of a' command.out)" -eq "$(grep -c '^\[yolo\]' "$assets/detector.cfg")" ] && pass || fail "other heads"
cp detector.onnx whole.onnx
printf '{"head": "yolov5"}\n' >detector.json
cp detector.json mine.json
expect_refusal 4 'detector.json: would be read as the description of detector.onnx; expected no such file' "converting beside a description" "$convert_weights" "${cfg[@]}" "${weights[@]}" --output detector.onnx
expect_same mine.json detector.json
expect_same whole.onnx detector.onnx
expect_refusal 2 'detector.onnx: is described by its cfg, not by detector.json' "detecting beside a description" "$detect" --weights detector.onnx "$frame"
rm detector.json
sed 's/^\[yolo\]/&\nscale_x_y=1.1/' "$assets/detector.cfg" >grown.cfg
expect_exit 0 "heads of other boxes" "$convert_weights" --cfg grown.cfg "${weights[@]}" --output grown.onnx
expect_exit 0 "detecting with them" "$detect" --json --weights grown.onnx "$frame"
cp command.out grown.json
expect_exit 0 "detecting with their cfg" "$detect" --json --cfg grown.cfg "${weights[@]}" "$frame"
expect_same grown.json command.out

expect_exit 2 "nothing given" "$convert_weights"
expect_refusal 2 "--decode is 'yolov5'; expected one of darknet, ultralytics, scaled" "converting to an unknown decode family" "$convert_weights" "${cfg[@]}" "${weights[@]}" --decode yolov5 --output no.onnx
expect_refusal 4 'detector.cfg:[0-9]+: .*needs activations, not logits' "converting raw logits to scaled" "$convert_weights" "${cfg[@]}" "${weights[@]}" --decode scaled --output no.onnx
expect_exit 2 "no epsilon" "$convert_weights" "${cfg[@]}" "${weights[@]}" --batch-norm-epsilon 0 --output no.onnx
cp "$assets/detector.weights" mine.weights
expect_exit 2 "overwriting the input" "$convert_weights" "${cfg[@]}" --weights mine.weights --output ./mine.weights
expect_same "$assets/detector.weights" mine.weights
expect_refusal 3 'absent.weights' "missing weights" "$convert_weights" "${cfg[@]}" --weights absent.weights --output no.onnx
head -c 5000 mine.weights >cut.weights
expect_exit 3 "cut weights" "$convert_weights" "${cfg[@]}" --weights cut.weights --output no.onnx
expect_refusal 3 'kept.onnx:@0: not Darknet weights; .* an ONNX model' "converted already" "$convert_weights" "${cfg[@]}" --weights kept.onnx --output no.onnx
head -c 4096 /dev/zero | cat mine.weights - >longer.weights
expect_exit 4 "weights of another cfg" "$convert_weights" "${cfg[@]}" --weights longer.weights --output no.onnx
expect_refusal 5 'absent/x.onnx' "a missing folder" "$convert_weights" "${cfg[@]}" "${weights[@]}" --output absent/x.onnx
[ -e no ] || [ -e no.onnx ] && fail "a refused conversion left a file" || pass
finish
