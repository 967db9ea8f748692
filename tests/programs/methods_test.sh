#!/usr/bin/env bash
# camouflage --method from the outside: bits, resuming, measuring again, refusals.
source "$(dirname "$0")/support.sh"
needs camouflage
mkdir frames && cp $(ls "$assets"/frames/test/*.npz | head -n 4) frames
quick=(--frames frames --texels 32 --epochs 6 --checkpoint-steps 1)
expect_exit 0 "fca" "$camouflage" "${quick[@]}" --output two

# Other methods than FCA's; FCA's manifest names no method, like older manifests.
grep -q '"method"' two/manifest.json && fail "a manifest names what was no choice before" || pass
expect_exit 0 "every method" "$camouflage" --list-methods
cp command.out methods
[ "$(wc -l <methods)" -ge 10 ] && pass || fail "$(wc -l <methods) methods"
while read -r -u 3 method usual; do
  [ "$method" != fca ] || continue
  few=("${quick[@]}" --method "$method" $usual)
  expect_exit 0 "$method" "$camouflage" "${few[@]}" --threads 2 --output "$method"
  grep -q "\"method\": \"$method\"" "$method/manifest.json" && pass || fail "the manifest does not name $method"
  expect_exit 0 "$method, one thread" "$camouflage" "${few[@]}" --threads 1 --output "$method-one"
  expect_same "$method/texture.npz" "$method-one/texture.npz"
  cmp -s "$method/texture.npz" two/texture.npz && fail "$method gives the texture of fca" || pass
  expect_exit 0 "$method measured again" "$programs/evaluate" --run "$method" --output "$method-again"
  expect_same "$method-again/metrics.csv" "$method/metrics.csv"
done 3<methods
expect_exit 0 "attention beside smoothness" "$camouflage" --frames frames --texels 32 --epochs 1 --method das --output smooth
grep -q "^warning: --method das: smoothness outweighs" command.err && pass || fail "no word on smoothness: $(cat command.err)"
[ "$(wc -l <random/history.csv)" = 1 ] && pass || fail "random was optimised"
kill_until_done killed_method 6 1 "$camouflage" "${quick[@]}" --method camou
expect_same killed_method/texture.npz camou/texture.npz
expect_exit 0 "a run that is not optimised resumed" "$camouflage" --resume --output random
expect_refusal 7 '--method \(was "camou", now "solid"\)' "a run resumed by another method" "$camouflage" --resume --method solid --output camou
expect_refusal 2 '--method .*dta' "an unknown method" "$camouflage" --method dta --output none
expect_refusal 2 '--method upc .*needs --texture atlas' "parts of cubes" "$camouflage" --method upc --texture cube --output none
expect_refusal 2 '--method das .*takes no --ensemble' "the attention of two detectors" "$camouflage" --method das --ensemble second.onnx --output none
expect_refusal 2 '--loss has no part in --method das' "a loss of attention" "$camouflage" --method das --loss paper --output none
expect_refusal 2 '--worst-views have no part in --method random' "steps of noise" "$camouflage" --method random --worst-views 0.5 --output none
expect_refusal 2 '--method rauca .*needs --light photo' "light that is not estimated" "$camouflage" --method rauca --output none
printf '%s\n' 'v 0 -1 0' 'v 0 1 0' 'v 0 0 1' 'v -2 0 0' 'vt 0 0' 'vt 1 0' 'vt .5 1' 'f 1/1 2/2 3/3' >front.obj
echo 1 >front.txt
front=(--method upc --mesh front.obj --faces front.txt)
expect_refusal 4 'front.obj: the method upc paints roof, hood and doors' "a car without panels" "$camouflage" "${front[@]}" --output none
expect_exit 4 "a check of a car without panels" "$camouflage" "${front[@]}" --check
[ -e none ] && fail "a refused method left a folder behind" || pass

# A method that moves the shape, too: it writes, and evaluate measures, another car.
moving=("${quick[@]}" --method mesh_adv --filter bilinear)
for file in texture.npz painted.obj painted.glb history.csv metrics.csv; do expect_same "mesh_adv/$file" "mesh_adv-one/$file"; done
of_kind() { grep "^$1 " "$2"; }
[ "$(of_kind f mesh_adv/painted.obj | sha256sum)" = "$(of_kind f two/painted.obj | sha256sum)" ] && pass || fail "the faces of the moved car"
[ "$(of_kind v mesh_adv/painted.obj | sha256sum)" != "$(of_kind v two/painted.obj | sha256sum)" ] && pass || fail "painted.obj has not moved"
cmp -s mesh_adv/painted.glb two/painted.glb && fail "painted.glb has not moved" || pass
paste <(of_kind v mesh_adv/painted.obj) <(of_kind v two/painted.obj) | awk '
  { for (k = 2; k <= 4; ++k) { off = $k - $(k + 4); if (off < 0) off = -off; if (off > most) most = off
      if (NR == 1 || $(k + 4) < low[k]) low[k] = $(k + 4); if (NR == 1 || $(k + 4) > high[k]) high[k] = $(k + 4) } }
  END { for (k = 2; k <= 4; ++k) if (high[k] - low[k] > long) long = high[k] - low[k]
    exit !(most > 0.001 * long && most <= 0.010001 * long) }' && pass || fail "positions leave their bounds, or stay"
kill_until_done killed_mesh_adv 6 1 "$camouflage" "${moving[@]}"
expect_same killed_mesh_adv/texture.npz mesh_adv/texture.npz
expect_exit 0 "a run beside one in another shape" "$programs/evaluate" --run two --filter bilinear --against mesh_adv --output beside
row() { sed -n "s/^$1,//p" "$2/metrics.csv" | cut -d, -f1-6; }
[ "$(row clean beside)" = "$(row clean mesh_adv)" ] && pass || fail "clean is not the car as it is"
[ "$(row 'other run' beside)" = "$(row adversarial mesh_adv)" ] && pass || fail "the other run is not measured in its shape"
awk '$1 == "vt" { $2 *= 2 } $1 == "f" { print "usemtl body" } { print }' front.obj >body.obj  # u as wide as the car's
expect_refusal 4 'mesh_adv/texture.npz: the shape does not fit the car' "a shape of another mesh" "$programs/evaluate" --run mesh_adv --mesh body.obj
expect_exit 4 "a shape of another mesh in a protocol" "$programs/evaluate" --run mesh_adv --mesh body.obj --protocol views
expect_error_line 'mesh_adv/texture.npz: the shape does not fit the car'

# Protocols draw the camouflage and its controls on the moved car, clean and unpainted pictures on the original one.
expect_exit 0 "photographs of a moved car" "$programs/evaluate" --run mesh_adv --protocol digital --output mesh_adv-digital
expect_figures_of_run mesh_adv/metrics.csv mesh_adv-digital/digital.csv
for protocol in physical attention occlusion; do
  quickly=(--protocol "$protocol" --quick --size 128)
  expect_exit 0 "$protocol of a moved car" "$programs/evaluate" --run mesh_adv "${quickly[@]}" --threads 2 --output "moved_$protocol"
  for file in command.out "moved_$protocol/$protocol".{md,json,html}; do
    grep -q 'on the car in the shape that the run has optimised' "$file" && pass || fail "$file does not name the shape"
  done
  expect_exit 0 "$protocol of the original car" "$programs/evaluate" --run two --filter bilinear "${quickly[@]}" --output "own_$protocol"
  grep -q 'optimised shape' command.out && fail "a car that has not moved has another shape" || pass
  of_texture() { grep -E "^([^,]*,){2}($1)," "$2_$protocol/$protocol.csv"; }
  [ "$(of_texture 'clean|photo|no car' moved)" = "$(of_texture 'clean|photo|no car' own)" ] && pass || fail "$protocol: clean has moved"
  [ "$(of_texture 'white|grey|red' moved)" != "$(of_texture 'white|grey|red' own)" ] && pass || fail "$protocol: controls have not moved"
done
expect_exit 0 "occlusion of a moved car, one thread" "$programs/evaluate" --run mesh_adv "${quickly[@]}" --threads 1 --output moved1
expect_same_report occlusion moved1 moved_occlusion
kill_until_measured moved2 --run mesh_adv "${quickly[@]}"
expect_same_report occlusion moved2 moved_occlusion
expect_exit 2 "a filter that knows no positions" "$camouflage" --method mesh_adv --output none
expect_error_line '--method mesh_adv moves the mesh, .*needs --filter bilinear and --light frame'
expect_exit 2 "light that knows no positions" "$camouflage" --method mesh_adv --filter bilinear --light photo --output none
expect_error_line '--method mesh_adv moves the mesh, .*needs --filter bilinear and --light frame'
expect_exit 0 "mesh_adv on cubes, under conditions, of a printer" "$camouflage" --frames frames --scenes 20 --texture cube --texels 3 --epochs 1 \
  --method mesh_adv --conditions camera jpeg --printability 1 --smooth-over picture --worst-views 0.5 --batch 2 --output mesh_adv_cubes
finish
