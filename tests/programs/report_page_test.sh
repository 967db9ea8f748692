#!/usr/bin/env bash
# The pages of a run, of its evaluation and of a hardening in a browser, as wide as a screen and as a telephone: drawn,
# listed, without an error, and without a fetched file; pictures as sharp as they are; the words of every figure in its frame,
# none on another. Skipped where there is no Chromium.
source "$(dirname "$0")/support.sh"
camouflage=$programs/camouflage
[ -x "$camouflage" ] || exit 77
for browser in chromium chromium-browser google-chrome; do
  if command -v "$browser" >/dev/null; then break; fi
done
command -v "$browser" >/dev/null || { echo "no Chromium: the page is not opened"; exit 77; }

mkdir frames && cp "$sources"/examples/assets/frames/test/00[0-3].npz frames
expect_exit 0 "a short run" "$camouflage" --frames frames --texels 16 --epochs 1 --output run
mkdir alone && cp run/report.html alone/run.html
if [ -x "$programs/evaluate" ]; then
  expect_exit 0 "its evaluation" "$programs/evaluate" --run run --conditions noise --draws 2 --output evaluation
  cp evaluation/report.html alone/evaluation.html
  expect_exit 0 "a protocol" "$programs/evaluate" --protocol views --quick --run run --controls matched --size 64 --output protocol
  cp protocol/views.html alone/protocol.html
  for kind in digital occlusion; do
    expect_exit 0 "$kind" "$programs/evaluate" --protocol $kind --quick --run run --controls matched --size 64 --output "$kind of a rather long name"
  done
  expect_exit 0 "a table" "$programs/tabulate" --output table --title "A title of so many words that they need two lines" "digital of a rather long name"
  # Drawings have a size, without which some viewers show nothing, and the key before what it explains.
  { sed '/<\/body>/d' alone/protocol.html && cat */{views,digital,occlusion,table}.svg && echo '</body>'; } >alone/figures.html
  for figure in */{views,digital,occlusion,table}.svg; do
    head -n 1 "$figure" | grep -Eq 'viewBox="0 0 ([0-9.]+) ([0-9.]+)" width="\1" height="\2"' && pass || fail "$figure: $(head -n 1 "$figure")"
    grep -nE 'class="(third|muted)"' "$figure" | head -n 1 >first && [ "$(cut -d: -f1 first)" -lt "$(grep -n 'class="title' "$figure" | head -n 1 | cut -d: -f1)" ] &&
      pass || fail "$figure: the legend is not at the head"
  done
fi
if [ -x "$programs/harden" ]; then
  expect_exit 0 "a short hardening" "$programs/harden" --frames frames --scenes 4 --texels 16 --attack-steps 1 --steps 1 --rounds 1 \
    --pictures 2 --clean-scenes 2 --test-scenes 2 --epochs 1 --output hardening
  cp hardening/report.html alone/hardening.html
fi

# open_page NAME WIDTH VIEWS SEARCH FOUND: result of the test's script on the page once it has settled. A frame sets the
# width; Chromium's own window has at least 500 pixels.
open_page() {
  cat "alone/$1.html" - >alone/page.html <<END
<script>setTimeout(() => {
  document.body.dataset.pictured = document.querySelector('.pictures img')?.src.slice(0, 15);
  const pictures = [...document.querySelectorAll('.pictures img')], drawings = [...document.querySelectorAll('svg')];
  document.body.dataset.blown = pictures.filter(i => i.width > i.naturalWidth).length;
  document.body.dataset.rowed = new Set(pictures.map(i => i.getBoundingClientRect().top)).size;
  document.body.dataset.boxes = [...document.querySelectorAll('.boxes span')].map(e => e.textContent.trim()).join('; ');
  document.body.dataset.buttons = document.querySelectorAll('#views button').length;
  document.body.dataset.drawings = drawings.length;
  document.body.dataset.misplaced = drawings.flatMap(drawing => {
    const all = drawing.getBoundingClientRect(), places = [...drawing.querySelectorAll('text')].map(e => [e.textContent, e.getBoundingClientRect()]);
    return places.filter(([words, at], i) => at.left < all.left || at.right > all.right || at.top < all.top || at.bottom > all.bottom ||
      places.slice(0, i).some(([other, of]) => at.left < of.right && of.left < at.right && at.top + 4 < of.bottom && of.top + 4 < at.bottom))
      .map(([words]) => words);
  }).join('; ');
  document.body.dataset.large = [...document.querySelectorAll('.pictures img')].map(i => i.naturalWidth + 'x' + i.naturalHeight).join(' ');
  const first = document.getElementById('chosen')?.textContent;
  document.getElementById('on')?.click();
  document.body.dataset.stepped = document.getElementById('chosen')?.textContent !== first;
  document.body.dataset.verdict = document.querySelector('.verdict')?.textContent;
  document.body.dataset.rows = document.querySelectorAll('#views tbody tr').length;
  const cut = table => table.getBoundingClientRect().right > table.parentNode.getBoundingClientRect().right + 1;
  document.body.dataset.cut = [...document.querySelectorAll('table')].filter(table => cut(table) &&
    getComputedStyle(table.parentNode).overflowX !== 'auto').length;
  document.body.dataset.whole = cut(document.getElementById('views')) ? 'no' : 'yes';
  document.body.dataset.beyond = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  const search = document.getElementById('search'); search.value = '$4'; search.oninput();
  document.body.dataset.searched = document.getElementById('count').textContent;
  document.body.dataset.cells = document.querySelectorAll('#views tbody td').length;
  document.body.dataset.headings = document.querySelectorAll('#views th').length;
  document.querySelectorAll('#views th')[0].click();
  document.body.dataset.sorted = document.querySelector('#views th').getAttribute('aria-sort');
}, 2000);</script>
END
  cat >alone/frame.html <<END
<iframe id="frame" src="page.html" style="border: 0; width: $2px; height: 900px"></iframe><script>setInterval(() => {
  const page = document.getElementById('frame').contentDocument;
  if (page.body?.dataset.sorted)
    Object.assign(document.body.dataset, page.body.dataset, page.getElementById('car')?.dataset);
}, 200);</script>
END
  timeout 100 "$browser" --headless --no-sandbox --no-first-run --disable-background-networking --disable-sync \
    --disable-component-update --disable-quic --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader \
    --user-data-dir="$PWD/profile-$1-$2" --virtual-time-budget=20000 --enable-logging=stderr --window-size=1400,1000 \
    --allow-file-access-from-files --dump-dom "file://$PWD/alone/frame.html" >dom 2>log
  local name="$1 at $2 px"
  attribute() { grep -oE "data-$1=\"[^\"]*\"" dom | cut -d'"' -f2; }
  [ "$(attribute rows)" = "$3" ] && pass || fail "$name: '$(attribute rows)' views are listed, not $3"
  [ "$(attribute searched)" = "$5 of $3 views" ] && pass || fail "$name: the search finds '$(attribute searched)'"
  [ "$(attribute headings)" -gt 5 ] && [ "$(attribute cells)" = $(($(attribute headings) * $5)) ] && pass ||
    fail "$name: '$(attribute cells)' cells under '$(attribute headings)' headings"
  [ "$(attribute sorted)" = ascending ] && pass || fail "$name: the heading does not sort"
  [ "$(attribute beyond)" = 0 ] && pass || fail "$name: the page is wider by '$(attribute beyond)' px"
  [ "$(attribute cut)" = 0 ] && pass || fail "$name: '$(attribute cut)' tables are cut and do not scroll"
  [ "$2" -lt 1280 ] || [ "$(attribute whole)" = yes ] && pass || fail "$name: the list of views is not whole"
  [ -z "$(attribute misplaced)" ] && pass || fail "$name: words beyond their drawing or on others: $(attribute misplaced)"
  grep -E 'CONSOLE.*(rror|arning)' log && fail "$name: errors in the browser" || pass
  case $1 in protocol | figures) [ "$(attribute drawings)" -gt 3 ] && pass || fail "$name: no drawings" && return ;; esac # tables and figures alone
  [ "$(attribute drawn || echo 0)" -gt 1000 ] && pass || fail "$name: the car covers '$(attribute drawn)' pixels"
  [ "$(attribute pictured)" = data:image/jpeg ] && pass || fail "$name: no picture of a view"
  [ "$(attribute large | wc -w)" -ge 2 ] && [ "$(attribute stepped)" = true ] && pass || fail "$name: pictures of '$(attribute large)', no step"
  [ "$(attribute blown)" = 0 ] && pass || fail "$name: '$(attribute blown)' pictures are larger than they are sharp"
  [ "$2" -lt 1280 ] || [ "$(attribute rowed)" = 1 ] && pass || fail "$name: the pictures of a view stand in '$(attribute rowed)' rows"
  [ "$(attribute buttons)" = "$3" ] && pass || fail "$name: '$(attribute buttons)' views to choose"
  grep -Eq '^the car, found: .*; (car|van|clutter)' <<<"$(attribute boxes)" && pass || fail "$name: the legend has '$(attribute boxes)'"
  [ "$1" = hardening ] || [ -n "$(attribute verdict)" ] && pass || fail "$name: no verdict"
}
for page in alone/*.html; do
  page=$(basename "$page" .html)
  grep -Eo '(src|href)="[^"]{0,40}' "alone/$page.html" |
    grep -Ev '^(src="data:|href="data:|href="[a-z_]+\.(glb|obj|npz|png|csv|json|md|txt|onnx)$)' &&
    fail "the page of $page needs other files" || pass
done
open_page run 1280 4 002 1
open_page run 390 4 002 1
for page in evaluation hardening; do
  [ ! -e "alone/$page.html" ] || open_page "$page" 390 4 002 1
done
[ ! -e alone/protocol.html ] || for page in protocol figures; do open_page $page 390 432 '0-45, 1.5' 9; done
finish
