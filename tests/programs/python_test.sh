#!/usr/bin/env bash
# The Python module: gradients against differences, a transposed map, and errors as exceptions.
source "$(dirname "$0")/support.sh"
ls "$programs"/python/tapestry*.so >/dev/null 2>&1 || {
  echo "skipped: the Python module is not built; it needs python3-dev, python3-pybind11 and pybind11-dev"
  exit 77
}
for python in python3 /usr/bin/python3 none; do
  PYTHONPATH=$programs/python "$python" -c 'import numpy, tapestry' 2>/dev/null && break
done
[ "$python" != none ] || {
  echo "skipped: no Python has NumPy and can load the module"
  exit 77
}
assets=$sources/examples/assets
cat >check.py <<'E2'
import sys
import numpy, tapestry
assets, photograph = sys.argv[1], numpy.load(sys.argv[2])
detector = tapestry.Detector(assets + "/detector.weights", config=assets + "/detector.cfg")
pictures = detector.fitted(photograph)
assert pictures.shape == (1, detector.height, detector.width, 3) and pictures.dtype == numpy.float32

run = detector.forward(pictures)
generator = numpy.random.default_rng(1)
weights = [generator.standard_normal(logits.shape).astype("float32") for logits in run.logits]
gradient = run.pull_back(weights)
direction = gradient / numpy.linalg.norm(gradient)
value = lambda x: sum(float(numpy.vdot(w.astype("float64"), l)) for w, l in zip(weights, detector.forward(x).logits))
step = 2e-3
slope = (value(pictures + step * direction) - value(pictures - step * direction)) / (2 * step)
length = float(numpy.vdot(gradient, direction))
assert abs(slope - length) < 0.05 * abs(length), (slope, length)
none = run.pull_back([None] * len(weights))
assert none.shape == pictures.shape and not none.any()
boxes = run.boxes(confidence=0.05)
assert len(boxes) == 1 and boxes[0].shape[1] == 6

whole = detector.forward((255 * pictures).round().astype("uint8"), unchecked=True).logits
assert all((a == b).all() for a, b in zip(whole, detector.forward((255 * pictures).round(), unchecked=True).logits))

view = tapestry.View(assets + "/car_sedan.obj", material="body", rows=16, size=96)
texels = generator.random((view.texel_count, 3), dtype="float32")
picture = view.render(texels)
assert picture.shape == (96, 96, 3) and view.coverage.max() == 1
adjoint = generator.standard_normal(picture.shape).astype("float32")
product = numpy.vdot(view.render(texels) - view.render(0 * texels), adjoint)
transposed = numpy.vdot(texels, view.pull_back(adjoint))
assert abs(product - transposed) < 1e-3 * abs(product), (product, transposed)

for wrong, said in [(lambda: detector.forward(pictures[0]), "pictures has 3 axes, expected 4"),
                    (lambda: detector.forward(pictures[:, :8]), "images"),
                    (lambda: detector.forward((255 * pictures).astype("uint8")), "pictures holds uint8"),
                    (lambda: detector.forward(255 * pictures), "expected floating-point RGB in [0, 1]"),
                    (lambda: detector.forward(pictures * numpy.nan), "pictures holds nan"),
                    (lambda: detector.fitted((255 * photograph).astype("uint8")), "a photograph holds uint8"),
                    (lambda: view.render(numpy.full_like(texels, numpy.inf)), "texels holds inf"),
                    (lambda: run.pull_back([]), "logits_adjoint has 0 arrays"),
                    (lambda: tapestry.Detector("absent.onnx"), "absent.onnx"),
                    (lambda: view.render(texels[1:]), "texels")]:
    try:
        wrong()
    except tapestry.Error as error:
        assert said in str(error), error
    else:
        raise AssertionError(said)
E2
"$python" -c 'import numpy; numpy.save("photograph.npy", numpy.random.default_rng(2).random((48, 80, 3), dtype="float32"))'
PYTHONPATH=$programs/python expect_exit 0 "the module" "$python" check.py "$assets" photograph.npy
finish
