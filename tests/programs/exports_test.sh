#!/usr/bin/env bash
# A run exports the paint that it optimised, for any texture coordinates of its mesh.
source "$(dirname "$0")/support.sh"
needs camouflage render

mkdir frames && cp "$assets"/frames/test/00[01].npz frames
cp "$assets"/car_sedan.{obj,mtl} .
cp "$assets/result.png" picture.png
printf '\nnewmtl hood\nKd 0.2 0.6 0.3\nmap_Kd picture.png\nnewmtl shell\nKd 0.2 0.6 0.3\n' >>car_sedan.mtl
with_u() { # with_u EXPRESSION FILE: the sedan with other u
  awk "\$1 == \"vt\" { u = \$2; print \"vt\", $1, \$3; next } { print }" car_sedan.obj >"$2"
}
with_u 'u / 2' halved.obj
with_u 'u' whole.obj
with_u '(u > 1 ? 2 - u : u)' mirrored.obj
with_u '(u > 1 ? u - 2 : u)' outside.obj
with_u '(u > 1.98 ? 1.01 : u / 2)' hardly.obj
sed -E '/^vt /d; s/([0-9]+)\/[0-9]*\/?([0-9]*)/\1/g' car_sedan.obj >plain.obj

difference() { grep -A 2 '"exported_paint"' "$1/metrics.json" | sed -n "s/.*\"$2\": \([0-9.e-]*\),*/\1/p"; }
exports_well() { # exports_well NAME OPTION...: a run on NAME.obj or --mesh, whose files show its paint
  local mesh=(--mesh "$1.obj")
  [ "$2" != --mesh ] || mesh=()
  expect_exit 0 "a run on $1.obj" "$camouflage" "${mesh[@]}" --material body --frames frames --epochs 2 \
    --learning-rate 0.5 --start random --output "$1" "${@:2}"
  for file in texture.png texture.json texture.npz painted.obj painted.glb; do expect_file "$1/$file"; done
  awk -v mean="$(difference "$1" mean_difference)" 'BEGIN { exit !(mean != "" && mean <= 0.02) }' && pass ||
    fail "the export of $1.obj differs by $(difference "$1" mean_difference)"
  grep -q 'the exported paint differs' command.err && fail "$1: $(cat command.err)" || pass
}
for mesh in halved whole mirrored outside hardly; do
  exports_well "$mesh" --texels 16
  expect_exit 0 "$mesh.obj with the texture" "$render" --mesh "$mesh.obj" --material body --texture "$mesh/texture.png" --size 128 \
    --output texture.png
  grep -q 'assumed' command.out && fail "$mesh: something is assumed beside a description" || pass
  expect_exit 0 "the exported $mesh" "$render" --mesh "$mesh/painted.obj" --size 128 --output painted.png
  expect_same texture.png painted.png
done
[ "$(sed -n 's/.*"width": \([0-9]*\).*/\1/p' halved/texture.json)" = 16 ] && pass || fail "half of the texels are never seen"
[ "$(sed -n 's/.*"width": \([0-9]*\).*/\1/p' whole/texture.json)" = 32 ] && pass || fail "another atlas of whole.obj"

# Without texture coordinates, or with shared ones, every face has a chart of its own in the exported mesh.
exports_well plain --texture cube --texels 4
cp mirrored.obj shared.obj
exports_well shared --texture cube --texels 4
for mesh in whole plain shared; do
  expect_exit 0 "$mesh measured again" "$programs/evaluate" --run "$mesh" --output "$mesh-again"
  expect_same "$mesh-again/painted.glb" "$mesh/painted.glb"
done
grep -q '^vt ' plain/painted.obj && pass || fail "the exported mesh has no texture coordinates"
[ "$("$render" --mesh plain/painted.obj --size 256 --output plain.png >/dev/null && wc -c <plain.png)" -gt 15000 ] && pass ||
  fail "the exported paint is of one colour"

# All faces of a colour at one point of a palette: an atlas has no texels for them, a cube has.
awk '$1 == "vt" { print "vt 0.25 0.5"; next } { print }' whole.obj >palette.obj
for check in "" --check; do
  expect_exit 4 "uv of a palette" "$camouflage" --mesh palette.obj --material body --frames frames --output none $check
  expect_error_line '^error: palette.obj: 100 % of the painted area has hardly a texel .*; --texture cube gives every face texels'
done
expect_exit 0 "one colour on a palette" "$camouflage" --mesh palette.obj --material body --frames frames --method solid --epochs 1 \
  --output one-colour
grep -q '^warning: palette.obj: 100 % of the painted area' command.err && pass || fail "no word on it: $(cat command.err)"
exports_well palette --texture cube --texels 4

# Several materials with texture coordinates, one painted, another with a picture of its own.
awk '$1 == "usemtl" && $2 == "body" && ++parts % 2 { print "usemtl hood"; next } { print }' whole.obj >several.obj
exports_well several --texels 16
exports_well several-cubes --mesh several.obj --texture cube --texels 4
faces_of() { awk -v name="$1" '$1 == "usemtl" { is_own = $2 == name } is_own && $1 == "f" { n++ } END { print n }' "$2"; }
for mesh in several several-cubes; do
  [ "$(faces_of paint "$mesh/painted.obj")" = "$(faces_of body several.obj)" ] && pass ||
    fail "$mesh: other faces than the painted ones are exported as painted"
  expect_exit 0 "$mesh measured again" "$programs/evaluate" --run "$mesh" --output "$mesh-again"
  expect_same "$mesh-again/painted.glb" "$mesh/painted.glb"
done

# The picture is drawn and exported beside the paint.
for mesh in several several-cubes; do
  [ "$(ls "$mesh"/painted-*.png | wc -l)" = 1 ] && pass || fail "$mesh: $(ls "$mesh")"
  expect_exit 0 "the hood as it was" "$render" --mesh several.obj --material body --colour 1 0 0 --size 96 --output red.png
  sed '/^map_Kd painted.png/d; /^newmtl paint$/{n;s/.*/Kd 1 0 0/}' "$mesh/painted.mtl" >"$mesh/red.mtl"
  sed "s/painted.mtl/red.mtl/" "$mesh/painted.obj" >"$mesh/red.obj"
  expect_exit 0 "the hood as it is exported" "$render" --mesh "$mesh/red.obj" --size 96 --output exported.png
  expect_same red.png exported.png
done
expect_exit 0 "the hood's picture" "$render" --mesh several.obj --material body --texture several/texture.png --size 128 \
  --output texture.png
expect_exit 0 "the hood's picture, exported" "$render" --mesh several/painted.obj --size 128 --output painted.png
expect_same texture.png painted.png
expect_exit 2 "a moved mesh with pictures" "$camouflage" --mesh several.obj --material body --texture cube --texels 4 \
  --frames frames --method mesh_adv --output moved
expect_error_line 'moves the mesh with its own textures \(map_Kd\); it needs --filter bilinear'

# A paint of another layout is refused, naming the found and the expected one. (N29)
otherwise='the texture is laid on a car in another way'
start=("$camouflage" --frames frames --epochs 1 --material body --output none)
expect_exit 4 "texels of another mesh" "${start[@]}" --mesh halved.obj --texels 16 --start whole/texture.npz
expect_error_line "^error: whole/texture.npz: $otherwise: texels; expected 256, found 512$"
expect_exit 4 "a cube's texels" "${start[@]}" --mesh plain.obj --texture cube --texels 4 --start whole/texture.npz
expect_error_line "$otherwise: kind; expected \"cube\", found \"atlas\"$"
expect_exit 4 "colours of another space" "${start[@]}" --mesh whole.obj --texels 16 --colour-space encoded --start whole/texture.npz
expect_error_line "$otherwise: colour_space; expected \"encoded\", found \"linear\"$"
sed 's/^usemtl body$/usemtl shell/' whole.obj >renamed.obj
measure=("$programs/evaluate" --run whole)
expect_exit 4 "another material" "${measure[@]}" --mesh renamed.obj --material shell
expect_error_line "whole/texture.npz: $otherwise: painted; expected .\"materials\":\\[\"shell\"\\]., found .\"materials\":\\[\"body\"\\].$"
expect_exit 4 "against a run of another layout" "${measure[@]}" --against halved
expect_error_line "^error: halved/texture.npz: $otherwise: texels; expected 512, found 256$"
expect_refusal 4 "$otherwise: up; expected \"y\", found \"z\"$" "other axes" "${measure[@]}" --object any --up y --forward z
expect_exit 4 "a protocol of another layout" "${measure[@]}" --object any --forward y --protocol views --quick
expect_error_line "$otherwise: forward; expected \"y\", found \"x\"$"
expect_exit 0 "another lookup" "${measure[@]}" --filter bilinear
grep -q '^whole/texture.npz: the texture is made for anisotropic lookup and drawn with bilinear$' command.out && pass ||
  fail "no word on the lookup"
if command -v zip >/dev/null; then
  cp -r whole older && zip -qd older/texture.npz layout.npy && sed -i 's/"outputs"/"none"/' older/manifest.json
  expect_exit 0 "a run without a description" "$programs/evaluate" --run older
  grep -q '^older/texture.npz: no description in it; assumed: laid as the mesh and the options say$' command.out && pass ||
    fail "nothing is said of what is assumed"
fi

# So with the atlas beside it: mesh and options must fit, or are taken from it.
draw=("$render" --texture whole/texture.png --size 128 --output drawn.png)
expect_exit 0 "the material of the description" "${draw[@]}" --mesh whole.obj
cp drawn.png adopted.png
expect_exit 0 "the same material" "${draw[@]}" --mesh whole.obj --material body
expect_same drawn.png adopted.png
expect_refusal 4 "^error: whole/texture.json: $otherwise: u_extent; expected 1.0, found 2.0$" "another u" "${draw[@]}" --mesh halved.obj
expect_exit 4 "another width in u" "${draw[@]}" --mesh whole.obj --u-extent 1
expect_error_line '^error: whole/texture.json: --u-extent is of another layout; expected 2.0, found 1.0$'
expect_refusal 4 "whole/texture.json: $otherwise: painted" "another material" "${draw[@]}" --mesh renamed.obj --material shell --panels panels.pdf
expect_refusal 4 "whole/texture.json: $otherwise: up" "another axis" "${draw[@]}" --mesh whole.obj --object any --up x --forward y
expect_exit 4 "charts of the faces on a mesh's own uv" "$render" --mesh shared.obj --material body --up z \
  --texture shared/texture.png --output none.png
expect_error_line '^error: shared.obj: shared/texture.png, of a run with --texture cube, .* expected --mesh shared/painted.obj$'
expect_exit 4 "the same as the page has it" "$render" --mesh shared.obj --texture shared/texture.png --output none.png
expect_error_line 'expected --mesh shared/painted.obj$'
expect_exit 0 "charts on the mesh that is written with them" "$render" --mesh shared/painted.obj --texture shared/texture.png \
  --size 128 --output charts.png
expect_exit 0 "that mesh alone" "$render" --mesh shared/painted.obj --filter bilinear --size 128 --output alone.png
expect_same charts.png alone.png

# A texture without a description: the assumptions are printed; a description of another picture is refused.
mkdir bare && cp halved/texture.png bare
expect_exit 0 "no description" "$render" --mesh halved.obj --material body --texture bare/texture.png --size 128 --output bare.png
grep -q '^bare/texture.png: no description beside it; assumed: its width is 1 in u' command.out && pass || fail "$(cat command.out)"
cp whole/texture.json bare
expect_exit 4 "another description" "$render" --mesh halved.obj --material body --texture bare/texture.png --output none.png
expect_error_line '^error: bare/texture.json: describes an atlas of other extents than bare/texture.png'
echo '{"format": "tapestry texture 1", "height": 16, "width": 16}' >bare/texture.json
expect_exit 3 "half a description" "$render" --mesh halved.obj --material body --texture bare/texture.png --output none.png
expect_error_line '^error: bare/texture.json: not the description of a texture'
finish
