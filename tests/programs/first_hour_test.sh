#!/usr/bin/env bash
# What a newcomer reads: the commands of README.md and docs/OWN_CAR.md, word for word and in their order. README's are followed
# in a clean clone and only with tests/run.sh --long, as are protocols. Files that a reader has stand-ins: a bundled car, drawn
# streets for photographs, the bundled detector for others.
source "$(dirname "$0")/support.sh"
needs make_dataset convert_weights
[ "${TAPESTRY_TESTS_LONG:-}" = ON ] && git -C "$sources" rev-parse --verify --quiet HEAD >/dev/null && long=true || long=false
# indented PAGE: its commands, which stand indented by four; a backslash joins lines. `#` begins what a line says of itself.
indented() { sed -n 's/^    //p' "$1" | sed -e ':a' -e '/\\$/N; s/\\\n *//; ta'; }
# inline PAGE: commands within sentences.
inline() { tr '\n' ' ' <"$1" | grep -oE '`(cmake --install|\.ci/packages|/usr/bin/python3 -m venv|venv/bin/pip wheel)[^`]*`' | tr -d '`'; }
# follow COMMAND: runs it as it is written, and for a page that says so in "the error", expects one.
follow() { case $1 in *'# the error'*) expect_exit 4 "$1" bash -c "$1" ;; *) expect_exit 0 "$1" bash -c "$1" ;; esac; }
# follow_readme: in a clone of the sources, which becomes an installation.
follow_readme() {
  git clone --quiet "$sources" clone
  cd clone || exit 1
  sed -n '/^<!-- compiled by the tests/,/^```$/p' README.md | grep -vE '^(<!--|```)' >gradient.cpp
  { indented README.md; inline README.md; } >../commands
  [ "$(wc -l <../commands)" -ge 6 ] && pass || fail "README has few commands: $(cat ../commands)"
  while IFS= read -r command; do
    case $command in
      tests/run.sh*) ;;  # runs this test
      'cmake --install'*) follow "DESTDIR=$PWD/../root $command" ;;
      *) follow "$command" ;;
    esac
  done <../commands
  expect_file runs/camouflage-001/report.html
  programs=$PWD/../root/usr/local/bin
  cd ..
}
if $long; then follow_readme; else echo "left out: README.md, a clone and protocols, which take --long"; fi

mkdir own own/photographs
cd own || exit 1
PATH=$programs:$PATH
cp "$assets/car_sedan.obj" car.obj
cp "$assets/car_sedan.mtl" . && cp "$assets/detector.names" coco.names
make_dataset --train 12 --test 2 --format png --output drawn >/dev/null
cp drawn/train/*.png photographs
cp "$(ls drawn/test/*.png | head -n 1)" photographs/street.jpg
for name in yolox_nano nanodet_m; do
  convert_weights --cfg "$assets/detector.cfg" --weights "$assets/detector.weights" --output "$name.onnx" >/dev/null
done
indented "$sources/docs/OWN_CAR.md" >commands
[ "$(wc -l <commands)" -ge 13 ] && pass || fail "OWN_CAR has few commands: $(cat commands)"
while IFS= read -r command; do
  case $command in
    *' --protocol '* | *run-2*) $long || continue ;;
    *' theirs.png '*) cp run/texture.png theirs.png ;;
  esac
  follow "$command"
done <commands
for name in look.png boxes frames/preview.png run/report.html painted.{glb,png} printed.png panels.pdf; do
  [ -e "$name" ] && pass || fail "the page leads to no $name"
done
finish
