#!/usr/bin/env bash
# What a run exports is the paint that it optimised, whatever texture coordinates its mesh has.
source "$(dirname "$0")/support.sh"
camouflage=$programs/camouflage
render=$programs/render
assets=$sources/examples/assets
[ -x "$camouflage" ] && [ -x "$render" ] && [ -e "$assets/detector.weights" ] || exit 77

mkdir frames && cp "$assets"/frames/test/00[01].npz frames
cp "$assets"/car_sedan.{obj,mtl} .
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
exports_well() { # exports_well NAME OPTION...: a run on NAME.obj, whose files show its paint
  expect_exit 0 "a run on $1.obj" "$camouflage" --mesh "$1.obj" --material body --frames frames --epochs 2 \
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

# Without texture coordinates, or with shared ones, every face has a chart of its own in what is exported.
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

# A texture without a description: what is assumed is said; a description of another picture is refused.
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
