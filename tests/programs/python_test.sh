#!/usr/bin/env bash
# The built Python package: results, refusals, stubs, notebook, and PyTorch if installed.
source "$(dirname "$0")/support.sh"
ls "$programs"/python/tapestry/_tapestry*.so >/dev/null 2>&1 || {
  echo "skipped: the Python package is not built; it needs python3-dev, python3-numpy and pybind11-dev"
  exit 77
}
export PYTHONPATH=$programs/python
for python in python3 /usr/bin/python3 none; do
  "$python" -c 'import numpy, tapestry' 2>/dev/null && break
done
[ "$python" != none ] || {
  echo "skipped: no Python has NumPy and can load the package"
  exit 77
}
assets=$sources/examples/assets
here=$sources/tests/programs
mkdir frames && cp "$assets"/frames/test/00[0-3].npz frames
expect_exit 0 "a camouflage" "$programs/camouflage" --frames frames --texels 16 --epochs 2 --output run
expect_exit 0 "the package" "$python" "$here/python_test.py" "$assets" run/texture.npz

# Its cells run unchanged beside the assets; at most 15 lines of them are code.
mkdir notebook && ln -s "$assets" assets && cd notebook || exit 1
cp "$sources/examples/python/fca.ipynb" .
expect_exit 0 "the notebook" "$python" "$here/notebook_test.py" fca.ipynb
[ "$(od -An -tx1 -N8 fca.png)" = " 89 50 4e 47 0d 0a 1a 0a" ] && pass || fail "the notebook ends without its picture"
cd ..

# README's lines run in the folder of the sources, which stands for a reader's clone; those of DETECTORS beside a detector.
ln -s "$sources/examples" examples
expect_exit 0 "a detector" "$programs/convert_weights" --cfg "$assets/detector.cfg" --weights "$assets/detector.weights" --output yolox_nano.onnx
cp "$assets/detector.names" coco.names && cp "$assets/result.png" street.jpg
for page in README.md docs/DETECTORS.md; do
  sed -n '/^```python$/,/^```$/ { /^```$/q; /^```/d; p }' "$sources/$page" >page.py
  [ "$(wc -l <page.py)" -ge 6 ] && pass || fail "$page shows no Python"
  expect_exit 0 "the lines of $page" "$python" page.py
done
expect_file painted.png

if "$python" -c 'import torch' 2>/dev/null; then
  expect_exit 0 "functions of PyTorch" "$python" "$here/torch_test.py" "$assets"
else
  echo "left out: functions of PyTorch, which is not installed"
fi
finish
