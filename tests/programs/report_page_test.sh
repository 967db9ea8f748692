#!/usr/bin/env bash
# The page of a run in a browser, as wide as a screen and as a telephone: drawn, listed, without an error, and with nothing
# fetched from beside it. Skipped where there is no Chromium.
source "$(dirname "$0")/support.sh"
camouflage=$programs/camouflage
[ -x "$camouflage" ] || exit 77
for browser in chromium chromium-browser google-chrome; do
  if command -v "$browser" >/dev/null; then break; fi
done
command -v "$browser" >/dev/null || { echo "no Chromium: the page is not opened"; exit 77; }

mkdir frames && cp "$sources"/examples/assets/frames/test/00[0-3].npz frames
expect_exit 0 "a short run" "$camouflage" --frames frames --texels 16 --epochs 1 --output run
mkdir alone && cp run/report.html alone/page.html
grep -Eo '(src|href)="[^"]{0,24}' alone/page.html | grep -Ev '^(src="data:|href="data:|href="[a-z_]+\.(glb|obj|npz|png|csv|json)$)' &&
  fail "the page needs other files" || pass
# What a script of the test's adds once the page has settled.
cat >>alone/page.html <<'END'
<script>setTimeout(() => {
  document.body.dataset.rows = document.querySelectorAll('#views tbody tr').length;
  document.body.dataset.beyond = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  const search = document.getElementById('search'); search.value = '002'; search.oninput();
  document.body.dataset.searched = document.getElementById('count').textContent;
  document.querySelectorAll('#views th')[0].click();
  document.body.dataset.sorted = document.querySelector('#views th').getAttribute('aria-sort');
}, 2000);</script>
END
for width in 1280 400; do
  timeout 100 "$browser" --headless --no-sandbox --no-first-run --disable-background-networking --disable-sync \
    --disable-component-update --disable-quic --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader \
    --user-data-dir="$PWD/profile-$width" --virtual-time-budget=6000 --enable-logging=stderr --window-size="$width,900" \
    --dump-dom "file://$PWD/alone/page.html" >dom 2>log
  attribute() { grep -oE "data-$1=\"[^\"]*\"" dom | cut -d'"' -f2; }
  [ "$(attribute rows)" = 4 ] && pass || fail "$width px: '$(attribute rows)' views are listed, not 4"
  [ "$(attribute searched)" = '1 of 4 views' ] && pass || fail "$width px: the search finds '$(attribute searched)'"
  [ "$(attribute sorted)" = ascending ] && pass || fail "$width px: the heading does not sort"
  [ "$(attribute beyond)" = 0 ] && pass || fail "$width px: the page is wider by '$(attribute beyond)' px"
  [ "$(attribute drawn || echo 0)" -gt 1000 ] && pass || fail "$width px: the car covers '$(attribute drawn)' pixels"
  grep -q 'id="below"[^>]*src="data:image/png' dom && pass || fail "$width px: no picture of a view"
  grep -E 'CONSOLE.*(rror|arning)' log && fail "$width px: errors in the browser" || pass
done
finish
