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
  cat alone/protocol.html <(sed "s/\(src\|href\)=[^ >]*//g" table/index.html) */{views,digital,occlusion,table}.svg >alone/figures.html
  for figure in */{views,digital,occlusion,table}.svg; do
    head -n 1 "$figure" | grep -Eq 'viewBox="0 0 ([0-9.]+) ([0-9.]+)" width="\1" height="\2"' && pass || fail "$figure: $(head -n 1 "$figure")"
    grep -oE 'class="(third|muted|title)' "$figure" | head -n 1 | grep -q title && fail "$figure: the legend is not at the head" || pass
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
  const is = document.body.dataset, all = (names, of = document) => [...of.querySelectorAll(names)], at = e => e.getBoundingClientRect();
  const pictures = all('.pictures img'), table = document.getElementById('views'), chosen = document.getElementById('chosen');
  is.pictured = pictures[0]?.src.slice(0, 15);
  is.blown = pictures.length < 2 ? 'few' : pictures.filter(i => i.width > i.naturalWidth).length;
  is.rowed = new Set(pictures.map(i => at(i).top)).size;
  is.boxes = all('.boxes span').map(e => e.textContent.trim()).join('; ');
  is.drawings = all('svg').length;
  is.misplaced = all('svg').flatMap(drawing => {
    const frame = at(drawing), words = all('text', drawing).map(e => [e.textContent, at(e)]);
    return words.filter(([, a], i) => a.left < frame.left || a.right > frame.right || a.top < frame.top || a.bottom > frame.bottom ||
      words.slice(0, i).some(([, b]) => a.left < b.right && b.left < a.right && a.top + 4 < b.bottom && b.top + 4 < a.bottom)).map(([text]) => text);
  }).join('; ');
  const first = chosen?.textContent;
  document.getElementById('on')?.click();
  is.stepped = chosen?.textContent !== first;
  all('button', table)[0]?.click();
  is.back = chosen?.textContent === first || all('button', table)[0]?.textContent === chosen?.textContent.split(/[ ,]/)[1];
  is.buttons = all('button', table).length;
  is.verdict = document.querySelector('.verdict')?.textContent;
  is.rows = all('tbody tr', table).length;
  const cut = table => at(table).right > at(table.parentNode).right + 1;
  is.cut = all('table').filter(table => cut(table) && getComputedStyle(table.parentNode).overflowX !== 'auto').length;
  is.whole = !cut(table);
  is.beyond = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  const search = document.getElementById('search'); search.value = '$4'; search.oninput();
  is.searched = document.getElementById('count').textContent;
  is.full = all('tbody td', table).length / all('th', table).length;
  all('th', table)[0].click();
  is.sorted = all('th', table)[0].getAttribute('aria-sort');
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
  is() { [ "$(attribute "$1")" = "$2" ] && pass || fail "$name: $1 is '$(attribute "$1")', not '$2'"; }
  is rows "$3" && is searched "$5 of $3 views" && is full "$5" && is sorted ascending
  is beyond 0 && is cut 0 && is misplaced ""
  [ "$2" -lt 1280 ] || is whole true
  grep -E 'CONSOLE.*(rror|arning)' log && fail "$name: errors in the browser" || pass
  case $1 in protocol | figures) [ "$(attribute drawings)" -gt 3 ] && pass || fail "$name: no drawings" && return ;; esac # tables and figures alone
  [ "$(attribute drawn || echo 0)" -gt 1000 ] && pass || fail "$name: the car covers '$(attribute drawn)' pixels"
  is pictured data:image/jpeg && is stepped true && is back true && is blown 0 && is buttons "$3"
  [ "$2" -lt 1280 ] || is rowed 1
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
