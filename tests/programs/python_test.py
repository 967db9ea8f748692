"""python_test.py ASSETS TEXTURE: the Python package against differences, transposed maps, formulas, and errors as exceptions."""
import ast
import pathlib
import re
import signal
import sys
import threading
import time

import numpy
import tapestry

assets = sys.argv[1]
generator = numpy.random.default_rng(1)
detector = tapestry.Detector(assets + "/detector.weights", config=assets + "/detector.cfg", names=assets + "/detector.names")
photograph = generator.random((48, 80, 3), dtype="float32")


def numbers(*shape):
    return generator.standard_normal(shape).astype("float32")


def require_near(value, expected, relative):
    assert abs(value - expected) <= relative * abs(expected), (value, expected)


def product(a, b):
    return float(numpy.vdot(numpy.asarray(a, dtype="float64"), b))


def detects_with_gradients():
    pictures = detector.fitted(photograph)
    assert pictures.shape == (1, detector.height, detector.width, 3) and pictures.dtype == numpy.float32
    run = detector.forward(pictures)
    weights = [numbers(*logits.shape) for logits in run.logits]
    gradient = run.pull_back(weights)
    direction = gradient / numpy.linalg.norm(gradient)

    def value(step):
        return sum(product(w, l) for w, l in zip(weights, detector.forward(pictures + step * direction).logits))
    require_near((value(2e-3) - value(-2e-3)) / 4e-3, product(gradient, direction), 0.05)
    assert not run.pull_back([None] * len(weights)).any()
    assert run.boxes(confidence=0.05)[0].shape[1] == 6 and not run.logits[0].flags.writeable


def reads_colours_by_type():
    levels = (255 * photograph).round().astype("uint8")
    whole = detector.fitted(levels)
    for same in (levels / 255, levels.astype("float32") / 255, (levels / 255).tolist()):
        assert numpy.abs(detector.fitted(same) - whole).max() < 1e-6


def finds_boxes_in_photographs():
    frame = tapestry.Frame(assets + "/frames/test/027.npz")
    height, width = frame.photograph.shape[:2]
    found = detector.detect(frame.photograph)[0]
    assert tapestry.iou([0, 0, 2, 1], [1, 0, 3, 1, 7]) == 1 / 3
    assert found[5] == frame.label[4] == detector.class_index("car") and numpy.abs(found[:4] - frame.label[:4]).max() < 0.1 * width
    twice = detector.detect(frame.photograph.repeat(2, 0).repeat(2, 1))[0]
    assert numpy.abs(twice[:4] - 2 * found[:4]).max() < 0.05 * width
    wide = numpy.full((3 * height, 5 * width, 3), 128, dtype="uint8")
    wide[2 * height:, 4 * width:] = frame.photograph
    small = tapestry.Detector(assets + "/detector.weights", assets + "/detector.cfg", size=5 * width // 32 * 32)
    moved = min(small.detect(wide, confidence=0.05), key=lambda row: numpy.abs(row[:4] - found[:4] - [4 * width, 2 * height] * 2).max())
    assert numpy.abs(moved[:4] - found[:4] - [4 * width, 2 * height] * 2).max() < 0.1 * width, (moved, found)


def hides_targets():
    frame = tapestry.Frame(assets + "/frames/test/027.npz")
    run = detector.forward(detector.fitted(frame.photograph))
    targets = frame.label[None]
    for loss in ("paper", "max_score", "vanish"):
        terms, adjoints = detector.adversarial(run.logits, targets, loss)
        directions = [adjoint / max(1e-12, numpy.abs(adjoint).max()) for adjoint in adjoints]

        def total(step):
            moved = [logits + step * direction for logits, direction in zip(run.logits, directions)]
            return detector.adversarial(moved, targets, loss)[0]["total"]
        require_near((total(1e-2) - total(-1e-2)) / 2e-2, sum(map(product, adjoints, directions)), 0.05)


def projects_by_matrix():
    car = tapestry.Mesh(assets + "/car_sedan.obj", material="body", rows=16, space="encoded")
    orbit = tapestry.Camera.orbit(0.7, 0.3, 8)
    focal = 48 / numpy.tan(0.4)
    camera = tapestry.Camera(orbit.view_from_world, [[focal, 0, 48], [0, focal, 48], [0, 0, 1]], 96, 96)
    light = tapestry.Light(0.6, 0.4, (1, 0.5, 1), (1, 0.9, 0.8))
    view, twin = (tapestry.View(car, each, 96, 96, light) for each in (orbit, camera))
    texels = generator.random((car.texel_count, 3), dtype="float32")
    picture = view.render(texels)
    assert numpy.abs(picture - twin.render(texels)).max() < 1e-4
    # The mesh is seen where the matrix puts its corners, and in half of a letterbox where it puts it there.
    seen = numpy.argwhere(view.coverage > 0)
    corners = car.positions @ orbit.view_from_world[:, :3].T + orbit.view_from_world[:, 3]
    rows = focal * corners[:, 1] / corners[:, 2] + 48
    assert abs(seen[:, 0].min() - rows.min()) < 1.5 and abs(seen[:, 0].max() + 1 - rows.max()) < 1.5
    wide = tapestry.View(car, orbit.fitted(48, 96, 96, 96), 96, 96, light).coverage  # as of 96 x 48 pixels
    boxed = numpy.argwhere(wide > 0)[:, 0]
    assert abs(boxed.min() - (24 + rows.min() / 2)) < 1 and abs(boxed.max() + 1 - (24 + rows.max() / 2)) < 1
    adjoint = numbers(*picture.shape)
    require_near(product(texels, view.pull_back(adjoint)), product(picture - view.render(0 * texels), adjoint), 1e-3)
    behind = generator.random((96, 96, 3), dtype="float32")
    covered = view.coverage[..., None]
    laid = tapestry.over(picture, view.coverage, behind)
    assert numpy.abs(laid - (picture + (1 - covered) * behind)).max() < 1e-6
    by_front, by_coverage, by_background = tapestry.over_adjoint(picture, view.coverage, behind, adjoint)
    assert numpy.abs(by_background - (1 - covered) * adjoint).max() < 1e-6
    assert numpy.abs(by_coverage + (behind * adjoint).sum(2)).max() < 1e-5 and (by_front == adjoint).all()
    mask = numpy.zeros((96, 96))
    mask[:-1, :-1] = 1
    steps = (numpy.diff(picture, axis=0)[:, :-1] ** 2).sum() + (numpy.diff(picture, axis=1)[:-1] ** 2).sum()
    total, slope = tapestry.smoothness(picture, mask)
    require_near(total, steps, 1e-4)
    require_near(product(slope, picture), 2 * steps, 1e-4)  # of a quadratic form


def steps_in_place():
    x, m, v = numbers(3, 2), 0, 0
    expected = x.astype("float64")
    adam = tapestry.Adam(6, learning_rate=0.1)
    for t in (1, 2, 3):
        slope = numbers(3, 2)
        m, v = 0.9 * m + 0.1 * slope, 0.999 * v + 0.001 * slope.astype("float64") ** 2
        expected -= 0.1 * m / (1 - 0.9 ** t) / (numpy.sqrt(v / (1 - 0.999 ** t)) + 1e-8)
        adam.step(x, slope)
    assert numpy.abs(x - expected).max() < 1e-5
    for wrong in (x.astype("float64"), x[:, :1]):
        try:
            adam.step(wrong, slope)
        except TypeError:
            continue
        raise AssertionError("copies what it is to change")


def camouflages():
    car = tapestry.Mesh(assets + "/car_sedan.obj", material="body", rows=16)
    frames = [tapestry.Frame(f"{assets}/frames/test/00{i}.npz") for i in range(4)]
    own = tapestry.Frame(frames[0].photograph, frames[0].camera, frames[0].mask, frames[0].light("encoded"))
    colours, history = tapestry.camouflage(detector, car, frames, epochs=6, batch=2)
    assert len(history) == 12 and history[-1]["total"] < history[0]["total"] and ((0 <= colours) & (colours <= 1)).all()
    for mine, theirs in zip(*(tapestry.composite(each, car, colours, detector) for each in (own, frames[0]))):
        assert (mine == theirs).all()
    assert tapestry.iou(mine, frames[0].label) > 0.9
    again, first = tapestry.camouflage(detector, car, frames, epochs=6, batch=2, callback=lambda step, terms: step == 5)
    assert first == history[:5] and (again != colours).any()
    program = numpy.load(sys.argv[2])["colours"]  # of the same settings
    assert (tapestry.camouflage(detector, car, frames, epochs=2)[0] == program).all()

    def divide(*_):
        return 1 / 0
    signal.signal(signal.SIGALRM, divide)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    for callback in (None, divide):  # a signal, and what the callback raises, end a run
        try:
            tapestry.camouflage(detector, car, frames, epochs=2000, callback=callback)
        except ZeroDivisionError:
            continue
        raise AssertionError("nothing ends the run")
    ticks, done = [], threading.Event()

    def tick():
        while not done.wait(0.001):
            ticks.append(time.monotonic())
    other = threading.Thread(target=tick)
    other.start()
    begin = time.monotonic()
    tapestry.camouflage(detector, car, frames, epochs=20)
    seconds = time.monotonic() - begin
    done.set()
    other.join()
    longest = max(numpy.diff([begin, *ticks]))
    assert longest < max(0.2, seconds / 4), f"the other thread waited for {longest} of {seconds} s"


def refuses():
    car = tapestry.Mesh(assets + "/car_sedan.obj", material="body", rows=16)
    pictures = detector.fitted(photograph)
    frame = tapestry.Frame(assets + "/frames/test/000.npz")
    view = tapestry.View(car, frame.camera, 32, 32)
    texels = numpy.zeros((car.texel_count, 3), dtype="float32")
    matrix = frame.camera.view_from_world
    for wrong, said in [(lambda: detector.forward(pictures[0]), "pictures has 3 axes, expected 4"),
                        (lambda: detector.forward(pictures[:, :8]), "images"),
                        (lambda: detector.forward(255 * pictures), "expected bytes, or floating-point RGB in [0, 1]"),
                        (lambda: detector.forward(pictures * numpy.nan), "pictures holds nan"),
                        (lambda: detector.forward((255 * pictures).astype("int64")), "pictures holds int64"),
                        (lambda: detector.detect(numpy.zeros((9, 9, 4))), "a photograph has 4 channels, expected 3"),
                        (lambda: detector.detect("photograph.png"), "a photograph holds <U14"),
                        (lambda: detector.detect(None), "a photograph holds object"),
                        (lambda: detector.forward(pictures).pull_back([]), "logits_adjoint has 0 arrays"),
                        (lambda: detector.adversarial(detector.forward(pictures).logits, [[0, 0, 9, 9]]), "expected 5 columns"),
                        (lambda: tapestry.iou([0, 0, 1], [0, 0, 1, 1]), "less than 4 numbers"),
                        (lambda: detector.class_index("lorry"), "lorry"),
                        (lambda: tapestry.Detector("absent.onnx"), "absent.onnx"),
                        (lambda: tapestry.Mesh("absent.obj"), "absent.obj"),
                        (lambda: tapestry.Mesh(assets + "/car_sedan.obj", kind="sphere"), "expected atlas, cube, vertex or solid"),
                        (lambda: view.render(numpy.full_like(texels, numpy.inf)), "texels holds inf"),
                        (lambda: view.render(texels[1:]), "texels"),
                        (lambda: tapestry.Camera(matrix[:2], numpy.eye(3), 9, 9), "view_from_world is 2 x 4, expected 3 x 4"),
                        (lambda: tapestry.Camera(2 * matrix, numpy.eye(3), 9, 9), "orthonormal"),
                        (lambda: tapestry.camouflage(detector, car, []), "no frame shows the mesh"),
                        (lambda: tapestry.camouflage(detector, car, [frame], batch=0), "batch"),
                        (lambda: tapestry.composite(frame, car, texels[1:], detector), "colours is"),
                        (lambda: tapestry.composite(frame, tapestry.Mesh(assets + "/car_sedan.obj", "body", rows=16, normalised=True), texels, detector),
                         "leave out normalised=True")]:
        try:
            wrong()
        except tapestry.Error as error:
            assert said in str(error), error
        else:
            raise AssertionError(said)


def is_described():
    """The stubs have the names and arguments of the module, and everything has a description."""
    described = {}
    for item in ast.parse(pathlib.Path(tapestry.__file__).with_suffix(".pyi").read_text()).body:
        for each in item.body if isinstance(item, ast.ClassDef) else [item]:
            if isinstance(each, ast.FunctionDef):
                name = each.name if item is each else f"{item.name}.{each.name}"
                described.setdefault(name, []).append([a.arg for a in each.args.args if a.arg != "self"])
    for name, found in sorted(described.items()):
        thing = tapestry
        for part in name.split("."):
            thing = getattr(thing, part)
        text = thing.fget.__doc__ if isinstance(thing, property) else thing.__doc__
        assert text, name + " is not described"
        if isinstance(thing, property) or name.startswith("Picture."):
            continue
        lines = [line for line in text.splitlines() if name.split(".")[-1] + "(" in line and "->" in line]
        stated = [[a for a in re.findall(r"[(,] *(\w+):", line) if a != "self"] for line in lines]
        assert found == stated, (name, found, stated)
    public = {f"{c}.{m}" for c, kind in vars(tapestry).items() if isinstance(kind, type) for m in vars(kind)
              if m == "__init__" or not m.startswith("_")} | {n for n in vars(tapestry) if callable(getattr(tapestry, n))}
    missing = {n for n in public if n not in described and n not in ("Error", "Error.__weakref__", "Run.__init__")
               and not isinstance(getattr(tapestry, n, None), type) and not n.startswith("_")}
    assert not missing, missing
    assert re.fullmatch(r"\d+\.\d+\.\d+", tapestry.__version__)


for check in (detects_with_gradients, reads_colours_by_type, finds_boxes_in_photographs, hides_targets, projects_by_matrix,
              steps_in_place, camouflages, refuses, is_described):
    print(check.__name__, flush=True)
    check()
