#!/usr/bin/env bash
# pip in a fresh clone, without network: the wheel has the same bytes in two folders, and what it installs runs elsewhere.
source "$(dirname "$0")/support.sh"
python=/usr/bin/python3
"$python" -c 'import ensurepip, numpy' 2>/dev/null && [ -d /usr/include/pybind11 ] && ls /usr/include/python3*/Python.h >/dev/null 2>&1 || {
  echo "skipped: it needs python3-venv, python3-dev, python3-numpy and pybind11-dev"
  exit 77
}
export CMAKE_CXX_COMPILER_LAUNCHER="sh;$sources/cmake/ccache.sh;$PWD"
alone=(unshare --map-root-user --net)
"${alone[@]}" true 2>/dev/null || alone=(env)
version=$(sed -n 's/.*TAPESTRY_VERSION_TEXT "\(.*\)"/\1/p' "$sources/include/tapestry/version.hpp")

for clone in one two; do
  mkdir $clone
  (cd "$sources" && git ls-files -z --cached --others --exclude-standard | xargs -0 cp --parents -t "$OLDPWD/$clone")
done
expect_exit 0 "an environment" "$python" -m venv --system-site-packages fresh
expect_exit 0 "pip wheel" "${alone[@]}" fresh/bin/pip wheel --no-index --wheel-dir wheels ./one
expect_exit 0 "pip install" "${alone[@]}" fresh/bin/pip install --no-index ./two
expect_exit 0 "the other wheel" "${alone[@]}" fresh/bin/pip wheel --no-index --wheel-dir again ./two
name=$(basename wheels/tapestry-"$version"-*.whl)
expect_same "wheels/$name" "again/$name"
grep -qaF "$PWD" wheels/*.whl one/build/python-*/examples/python/tapestry/*.so && fail "the wheel names the folder of its sources" || pass
rm -r one two
expect_exit 0 "the installed package" "${alone[@]}" fresh/bin/python - "$sources/examples/assets" "$version" <<'END'
import importlib.metadata, os, sys, tapestry
assets, version = sys.argv[1:]
assert tapestry.__version__ == importlib.metadata.version("tapestry") == version
assert os.path.exists(os.path.join(os.path.dirname(tapestry.__file__), "py.typed"))
detector = tapestry.Detector(assets + "/detector.weights", assets + "/detector.cfg")
assert len(detector.detect(tapestry.read_picture(assets + "/frames/test/000.npz"))) > 0
END
# Without NumPy the package names the remedy.
expect_exit 0 "an environment without packages" "$python" -m venv bare
expect_exit 0 "pip without NumPy" bare/bin/pip install --no-index "wheels/$name"
expect_exit 1 "without NumPy" bare/bin/python -c 'import tapestry'
grep -q 'ImportError: tapestry needs NumPy: apt install python3-numpy' command.err && pass || fail "$(cat command.err)"
finish
