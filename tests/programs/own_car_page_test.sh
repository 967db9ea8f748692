#!/usr/bin/env bash
# docs/OWN_CAR.md: its commands, with a bundled car, small numbers and a drawn "photograph" for what a reader has, lead to a
# report, and every option that it names exists.
source "$(dirname "$0")/support.sh"
page=$sources/docs/OWN_CAR.md
# Commands stand indented by four; a backslash joins lines.
sed -n 's/^    //p' "$page" | sed -e ':a' -e '/\\$/N; s/\\\n *//; ta' | sed 's/ *#.*//' >commands
[ "$(wc -l <commands)" -ge 9 ] && pass || fail "the page has few commands: $(cat commands)"
while read -r program rest; do
  "$programs/$program" --help >help 2>&1 || fail "the page names $program, which is no program"
  for option in $(grep -oE -- '--[a-z-]+' <<<"$rest"); do
    grep -qE -- "(^| |,)$option( |$|,)" help && pass || fail "$program has no option $option"
  done
done <commands

cp "$sources/examples/assets/car_sedan.obj" car.obj
cp "$sources/examples/assets/car_sedan.mtl" car_sedan.mtl
mkdir photographs
for i in 1 2 3 4; do
  "$programs/render" --mesh car.obj --azimuth $((90 * i)) --distance 80 --size 96 --output "photographs/$i.png" >/dev/null
done
expect_exit 0 "the car alone" "$programs/render" --mesh car.obj --output look.png
expect_exit 4 "the car's materials" "$programs/render" --mesh car.obj --material '?'
grep -q "it has 'body'" command.err && pass || fail "no list of materials: $(cat command.err)"
expect_exit 0 "a preview" "$programs/make_dataset" --mesh car.obj --material body --length 4.9 --backgrounds photographs \
  --camera-height 1.6 --camera-pitch 5 --train 4 --test 2 --size 96 --output frames --check
expect_file frames/preview.png
expect_exit 0 "frames" "$programs/make_dataset" --mesh car.obj --material body --length 4.9 --backgrounds photographs \
  --camera-height 1.6 --camera-pitch 5 --train 4 --test 2 --size 96 --output frames
next=$(sed -n 's/^next: //p' command.out command.err)
[ "$next" = "camouflage --frames frames --mesh car.obj --material body --output run" ] && pass || fail "the next command: $next"
# The bundled detector sees no car in pictures as small as these, and --check says so after all else is sound.
expect_exit 4 "the printed command, checked" bash -c "\"$programs\"/$next --check"
expect_error_line "the car is found as 'car' in none of 2 clean views"
expect_exit 0 "the printed command" bash -c "\"$programs\"/$next --epochs 1 --texels 8"
expect_file run/report.html
finish
