#!/usr/bin/env bash
# Common to all programs: --help, --version, --config, hints; and their installation.
source "$(dirname "$0")/support.sh"
names="camouflage convert_weights detect evaluate harden make_dataset render train_detector train_segmenter"
[ -e "$programs/../CMakeCache.txt" ] || exit 77
for name in $names; do [ -x "$programs/$name" ] || exit 77; done
frame=$(ls "$assets"/frames/test/*.npz | head -n 1)
version=$(sed -n 's/.*TAPESTRY_VERSION_TEXT "\(.*\)"/\1/p' "$sources/include/tapestry/version.hpp")

for name in $names make_assets; do
  expect_exit 0 "$name --version" "$programs/$name" --version
  [ "$(cat command.out)" = "$name (Tapestry) $version" ] && pass || fail "$name --version says $(cat command.out)"
  expect_exit 0 "$name --help" "$programs/$name" --help
  cp command.out help
  [ -z "$(grep -E '.{81}' help)" ] && pass || fail "$name --help is wider than 80 columns: $(grep -E '.{81}' help)"
  grep -q "/" <(grep '^Usage' help) && fail "$name --help shows a path" || pass
  tr -s '\n ' ' ' <help | grep -qF -e '=[]' -e '=""' -e "=$assets" && fail "$name --help shows a default that is none" || pass
  grep -q '^Exit status:$' help && grep -q '^Examples:$' help && pass || fail "$name --help lacks examples or exit codes"
  [ "$(grep -c '^[A-Z][A-Za-z ]*:$' help)" -ge 4 ] || [ "$name" = convert_weights ] || [ "$name" = make_assets ] ||
    [ "$name" = make_dataset ] || [ "${name#train_}" != "$name" ] && pass || fail "$name --help has no groups"
  # An option of an example is one that the program knows.
  for word in $(sed -n '/^Examples:$/,/^$/p' help | grep -oE -- ' --[a-z-]+'); do
    grep -qE "^  (.*,)?$word( |,|$)" help && pass || fail "an example of $name has $word"
  done
  expect_refusal 2 'unknown option --bogusly$' "$name with an option that is like no other" "$programs/$name" --bogusly
done
expect_refusal 2 'unknown option --azimtuh; did you mean --azimuth\?$' "a near miss" "$programs/render" --azimtuh 3
expect_refusal 2 'did you mean --cfg' "neighbours exchanged in a short word" "$programs/convert_weights" --cgf x

# A file may hold the options of the command line, which wins.
convert=$programs/convert_weights
"$convert" --cfg "$assets/detector.cfg" --weights "$assets/detector.weights" --fold --output expected.onnx >/dev/null
printf '%s\n' "# a comment" "cfg = \"$assets/detector.cfg\"" "weights = '$assets/detector.weights'" "fold = true" \
  'output = "from a file.onnx"' >convert.toml
expect_exit 0 "all options from a file" "$convert" --config convert.toml
expect_same expected.onnx "from a file.onnx"
expect_exit 0 "the command line wins" "$convert" --config convert.toml --output elsewhere.onnx
expect_same expected.onnx elsewhere.onnx
printf '\xEF\xBB\xBF' | cat - convert.toml >marked.toml
expect_exit 0 "a file with a byte order mark" "$convert" --config marked.toml --output marked.onnx
expect_same expected.onnx marked.onnx
sed '1d; s/^cfg/\xEF\xBB\xBFcfg/' convert.toml >marked.toml
expect_exit 0 "a byte order mark before an option" "$convert" --config marked.toml --output marked.onnx
expect_same expected.onnx marked.onnx
sed 's/fold = true/fold = false/' convert.toml >plain.toml
expect_exit 0 "a flag left out" "$convert" --config plain.toml --output plain.onnx
grep -q 'batch normalisation kept' command.out && pass || fail "fold = false folds"

# --quiet prints results, warnings and errors; --verbose prints more.
sed 's/^\[net\]/[net]\nwidht=3/' "$assets/detector.cfg" >odd.cfg
odd=(--cfg odd.cfg --weights "$assets/detector.weights" --output odd.onnx)
expect_exit 0 "a quiet program" "$convert" --quiet "${odd[@]}"
[ -s command.out ] && fail "--quiet prints $(cat command.out)" || pass
grep -q '^warning: ' command.err && [ "$(wc -l <command.err)" -eq 1 ] && pass || fail "--quiet hides a warning"
expect_exit 0 "a verbose program" "$convert" --verbose "${odd[@]}"
grep -q '^odd.onnx: ' command.out && grep -q '^[0-9.]* s, [0-9]* MiB at most, [0-9]* waits, [0-9]* page faults$' command.err && pass ||
  fail "--verbose does not say what it took"
expect_exit 2 "quiet and verbose" "$convert" --quiet --verbose "${odd[@]}"
expect_exit 0 "quiet detections" "$programs/detect" --quiet "$frame"
grep -q '^  car ' command.out && [ "$(grep -c '^fit ' command.out)" -eq 0 ] && pass || fail "quiet detections are not alone"

refused() { # refused EXIT PATTERN LINE...: the lines as a file
  printf '%s\n' "${@:3}" >refused.toml
  expect_exit "$1" "a file with '$3'" "$programs/render" --config refused.toml --output refused.png
  expect_error_line "$2"
}
refused 2 '^error: refused.toml: .*not able to parse azimth$' 'azimth = 3'
refused 2 '^error: refused.toml: config: ' 'config = "refused.toml"'
refused 2 "^error: refused.toml: option 'azimuth' is given twice$" 'azimuth = 3' 'fov = 50' 'azimuth = 4'
refused 2 '^error: ' 'azimuth = 3' 'azimuth = 4'
refused 2 '^error: refused.toml: .*not able to parse render' '[render]' 'azimuth = 3'
refused 2 "^error: refused.toml: option 'mesh': a quotation mark" 'mesh = "car.obj'
refused 2 "^error: refused.toml: option 'mesh': a quotation mark" "mesh = 'car.obj"
refused 2 "^error: refused.toml: option 'mesh': a quotation mark" "mesh = \"'tis.obj\""
for name in '"car #1.obj"' "'car #1.obj'"; do # CLI11 2.3 ends the value at the #, 2.4 does not
  printf 'mesh = %s\n' "$name" >refused.toml
  if "$programs/render" --config refused.toml --output refused.png >command.out 2>command.err; then
    fail "a mesh that is not there was drawn"
  fi
  expect_error_line "^error: (refused.toml: option 'mesh': a|car #1.obj: cannot open)"
done
refused 2 "azimuth.*expected a finite number, found 'east'" 'azimuth = east'
refused 2 'threads.*expected a whole number' 'threads = 1.5'
refused 2 'background' 'background = [1, 0]'
[ -e refused.png ] && fail "a refused file drew a picture" || pass
expect_refusal 3 '^error: absent.toml: cannot open: No such file or directory$' "a file that is not there" "$programs/render" --config absent.toml
expect_exit 3 "a folder" "$programs/render" --config /
expect_refusal 3 '^error: /dev/zero: not a regular file$' "a file without end" "$programs/render" --config /dev/zero
mkfifo pipe
mkdir one && cp "$frame" one
expect_refusal 3 '^error: pipe: not a regular file$' "a FIFO that nobody writes to" timeout 20 "$programs/render" --config pipe
for option in mesh frames cfg weights names faces palette detector; do
  given=("--$option" pipe)
  [ "$option" = frames ] || given+=(--frames one)
  [ "$option" != palette ] || given+=(--printability 1)
  [ "$option" != weights ] || given+=(--cfg "$assets/detector.cfg")
  [ "$option" != cfg ] || given+=(--weights "$assets/detector.weights")
  [ "$option" != mesh ] || given+=(--material body)
  [ "$option" != faces ] || given+=(--mesh "$assets/car_sedan.obj")
  [ "$option" != detector ] || given+=(--weights model.onnx)
  expect_exit 3 "a FIFO for --$option" timeout 20 "$programs/camouflage" --check "${given[@]}"
done
head -c 2000000 /dev/zero | tr '\0' '\n' >large.toml
expect_exit 8 "a large file" "$programs/render" --config large.toml
head -c 1000000 /dev/zero | tr '\0' 'a' >long.toml
expect_exit 2 "one long line" "$programs/render" --config long.toml
printf 'mesh = "%s"\n' "$(head -c 1000000 /dev/zero | tr '\0' 'a')" >value.toml
expect_exit 3 "a long value" "$programs/render" --config value.toml
[ "$(wc -c <command.err)" -lt 2200 ] && grep -q '^error: aaa.*bytes left out' command.err && pass ||
  fail "$(wc -c <command.err) bytes are printed of a long value"
head -c 1000000 /dev/zero | tr '\0' '.' >dots.toml
expect_exit 2 "many dots" "$programs/render" --config dots.toml
printf '%s\n' 'size = [40, 30]' 'background = [0, 0.5, 1]' 'view = "normal"' >picture.toml
expect_exit 0 "lists from a file" "$programs/render" --config picture.toml --output file.png
expect_exit 0 "the same lists" "$programs/render" --size 40 30 --background 0 0.5 1 --view normal --output line.png
expect_same file.png line.png

# A run whose options come from a file is the same run, and is resumed with the file or without.
mkdir frames && cp "$frame" frames
printf '%s\n' 'frames = "frames"' 'texels = 8' 'epochs = 3' 'conditions = ["light", "blur"]' 'threads = 2' >run.toml
camouflage=$programs/camouflage
expect_exit 0 "a run from a file" "$camouflage" --config run.toml --output file
printf 'quiet = true\n' | cat - run.toml >quiet.toml
expect_exit 0 "a quiet run from a file" "$camouflage" --config quiet.toml --output quiet
[ -s command.err ] && fail "a quiet run says $(cat command.err)" || pass
grep -q '^  adversarial ' command.out && [ "$(grep -c '^report: ' command.out)" -eq 0 ] && pass || fail "quiet results are not alone"
expect_exit 0 "a verbose run from a file" "$camouflage" --config run.toml --verbose --output verbose
[ "$(grep -c '^step [123]/3 ' command.err)" -eq 3 ] && pass || fail "a verbose run does not tell every step"
expect_same file/texture.npz quiet/texture.npz
expect_same file/manifest.json verbose/manifest.json
expect_exit 0 "the same from the command line" "$camouflage" --frames frames --texels 8 --epochs 3 --conditions light blur \
  --threads 2 --output line
expect_same_files file line texture.npz manifest.json
expect_exit 0 "resuming it with the file" "$camouflage" --config run.toml --resume --output file
expect_exit 0 "resuming it without" "$camouflage" --resume --output file
sed 's/epochs = 3/epochs = 4/' run.toml >other.toml
expect_refusal 7 '\-\-epochs \(was 3, now 4\)' "resuming with another file" "$camouflage" --config other.toml --resume --output file
"$camouflage" --config run.toml --epochs 100000 --output stopped >/dev/null 2>stopped.err &
process=$!
wait_for 30 [ -e stopped/manifest.json ]
sleep 1
stop INT "$process"
[ $? -eq 130 ] && pass || fail "not stopped"
grep -q -- '--resume --output stopped --threads 2$' stopped.err && pass || fail "to go on: $(cat stopped.err)"

# Installed, the programs find the bundled files beside them, and have pages and completions.
expect_exit 0 "installing" cmake --install "$programs/.." --prefix "$PWD/prefix"
for name in $names; do
  expect_exit 0 "installed $name" "prefix/bin/$name" --version
  gzip -dc "prefix/share/man/man1/$name.1.gz" >page || fail "no page of $name"
  grep -A 1 '^\.SH NAME' page | grep -q "^$name \\\\- [a-z][^:.]*$" && pass ||
    fail "the page of $name has no line for whatis"
  bash -n "prefix/share/bash-completion/completions/$name" && pass || fail "the completion of $name is no script"
  for option in $("$programs/$name" --help | grep -oE '^  --[a-z-]+'); do
    grep -q -- "B ${option//-/\\\\-}" page && pass || fail "$option is not in the page of $name"
    grep -q -- "[ \"]$option " "prefix/share/bash-completion/completions/$name" && pass || fail "$option is not completed"
  done
done
# Completed are options, the words that a refusal lists, and folders: by bash, and by fish and zsh where they are installed.
completed() { # WORD...: what the last one is completed to, in order
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  "_tapestry_$1" "$1" "${!#}" "${COMP_WORDS[COMP_CWORD - 1]}"
  printf '%s\n' "${COMPREPLY[@]}" | sort | paste -s -d ' '
}
expect_completed() { # RESULT WORD...
  [ "$(completed "${@:2}")" = "$1" ] && pass || fail "${*:2} is completed to '$(completed "${@:2}")', not '$1'"
}
mkdir -p runs/first && touch runs.txt
# shellcheck disable=SC1090
for name in render camouflage evaluate; do source "prefix/share/bash-completion/completions/$name"; done
expect_completed --azimuth render --az
expect_completed silhouette camouflage --mask = sil
expect_completed "blur" camouflage --conditions camera bl
expect_completed "" camouflage --batch ""
expect_completed runs evaluate --run ru
for option in camouflage:{mask,texture,filter,light,unpainted,colour-space,fit,decode,precision,method,controls,smooth-over,start,up,forward,object} \
  render:{filter,light,view,paper} "evaluate --clean-only:protocol"; do
  program=${option%:*} option=${option#*:}
  # shellcheck disable=SC2086  # several words on purpose
  words=$("$programs/"$program --"$option" wrong 2>&1 | sed -n 's/.*expected one of \([^;]*\).*/\1/p' | tr -d ,)
  program=${program% *}
  expect_completed "$(printf '%s\n' $words | sort | paste -s -d ' ')" "$program" --"$option" ""
  [ -n "$words" ] && grep -q -- "-l $option -[xr].* -a '.*${words%% *}" "prefix/share/fish/vendor_completions.d/$program.fish" &&
    grep -q -- "--$option=.*[( ]${words%% *}[) ]" "prefix/share/zsh/site-functions/_$program" && pass || fail "no words of $program --$option: $words"
done
if command -v fish >/dev/null; then
  found=$(fish -c "source prefix/share/fish/vendor_completions.d/camouflage.fish; complete -C 'camouflage --mask s'")
  [ "${found%%$'\t'*}" = silhouette ] && pass || fail "fish completes camouflage --mask s to '$found'"
else echo "fish is not installed: its completions are not tried"; fi
if command -v zsh >/dev/null; then
  found=$(zsh -f -c '_arguments() { print -rl -- "$@" }; source prefix/share/zsh/site-functions/_camouflage' | grep -- '^--mask=')
  [[ $found == *':mask:(auto silhouette file u2net)' ]] && pass || fail "zsh completes --mask by '$found'"
else echo "zsh is not installed: its completions are not tried"; fi
expect_exit 0 "drawing what is bundled" prefix/bin/render --size 32 --output bundled.png
mv prefix moved
expect_exit 0 "installed and moved" moved/bin/detect --json moved/share/tapestry/assets/frames/test/000.npz
cp command.out moved.json
expect_exit 0 "not installed" "$programs/detect" --json "$assets/frames/test/000.npz"
sed 's/"image": .*//' command.out >here.json
sed -i 's/"image": .*//' moved.json
expect_same here.json moved.json
finish
