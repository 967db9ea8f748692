#!/usr/bin/env bash
# The benchmark "detector" on a tiny network, with ours alone.
source "$(dirname "$0")/support.sh"
built=$programs/../benchmarks
[ -x "$built/detector" ] && [ -x "$built/detector_tapestry" ] || exit 77
mkdir alone && cp "$built/detector" "$built/detector_tapestry" alone
convolution() {
  printf '[convolutional]\nbatch_normalize=%s\nfilters=%s\nsize=3\nstride=%s\npad=1\nactivation=%s\n' "$@"
}
{
  printf '[net]\nwidth=32\nheight=32\nchannels=3\n'
  convolution 1 8 2 leaky
  printf '[maxpool]\nsize=2\nstride=2\n'
  convolution 1 8 1 leaky
  convolution 0 21 1 linear
  printf '[yolo]\nmask=0,1,2\nanchors=10,14, 23,27, 37,58\nclasses=2\nnum=3\n'
} >tiny.cfg
endless=(alone/detector --cfg tiny.cfg --size 64 --seconds 0.001 --output results --rounds 1000000)
detector=("${endless[@]:0:9}" --rounds 2)

expect_exit 0 "all cases" "${detector[@]}"
csv=results/detector.csv
[ "$(head -n 1 $csv)" = "case,variant,threads,seconds,error,memory_mib,spread,version,commit,compiler,instruction_set,processor" ] && pass || fail "header: $(head -n 1 $csv)"
for row in "tiny-64 forward,automatic,1" "tiny-64 forward,automatic,2" "tiny-64 forward+gradient,automatic,1"; do
  grep -Eq "^${row//+/\\+}(,[0-9][0-9.e+-]*){4},[0-9]" $csv && pass || fail "no numbers for $row"
done
grep -q "^tiny-64 forward,peer:OpenCV,1,,,,,[0-9]" $csv && pass || fail "a peer that was not built has a value"
awk -F, 'NR > 1 && $5 != "" && !($4 > 0 && $5 > 0 && $5 < ($2 == "bfloat16" ? 2e-2 : 1e-5) && $6 > 0)' $csv >wrong.csv
[ -s wrong.csv ] && fail "impossible numbers: $(cat wrong.csv)" || pass
grep -q "<svg" results/detector.svg && grep -q "automatic" results/detector.svg && pass || fail "no figure"
ls results/detector-files | grep -q answer && fail "answers are left behind" || pass

expect_exit 0 "one case" "${detector[@]}" --case 'forward$' --threads 1
[ "$(grep -c automatic $csv)" -eq 1 ] && pass || fail "--case or --threads is not heeded"
cp $csv before.csv
expect_exit 2 "no such case" "${detector[@]}" --case backward
expect_refusal 2 'error: --case' "a pattern that is none" "${detector[@]}" --case '('
expect_exit 3 "a missing cfg" alone/detector --cfg absent.cfg --output results
timeout --signal=INT 1 "${endless[@]}" >/dev/null 2>&1
[ $? -eq 124 ] && pass || fail "the endless run ended by itself"
expect_same $csv before.csv
[ "$(find results -maxdepth 1 -type f | wc -l)" -eq 2 ] && pass || fail "an interrupted run leaves a file behind"
finish
