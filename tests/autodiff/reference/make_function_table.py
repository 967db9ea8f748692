#!/usr/bin/env python3
"""Writes function_table.txt: values and derivatives of every scalar function, by mpmath alone.

Derivatives are central differences in 3,400 bits with a step of 2^-400 of the distance to the nearest
singularity, so their definition and no formula of ours; those of gamma functions are polygammas. A line is
    f NAME ARGUMENTS
or, after it, a point: arguments, f, f', f'', f''' (of two arguments: f, fx, fy, fxx, fxy, fyy, fxxx, fyyy),
each the 16 hexadecimal digits of a double, rounded correctly. Deterministic; takes some minutes.
"""
import math
import random
import struct
import sys

from mpmath import mp, mpf

mp.prec = 3400
STEP = mpf(2) ** -400
TINY, LEAST, MOST = 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308


def to_double(x):
    """Correctly rounded, to denormals, too."""
    if not mp.isfinite(x):
        return float(x)
    sign, mantissa, exponent, bits = x._mpf_
    if mantissa == 0 or bits + exponent < -1080:
        return 0.0
    if bits + exponent > 1030:
        return -math.inf if sign else math.inf
    try:
        value = mantissa * (1 << exponent) if exponent >= 0 else mantissa / (1 << -exponent)
        value = float(value)
    except OverflowError:
        value = math.inf
    return -value if sign else value


def digits(x):
    return struct.pack(">d", x).hex()


def neighbours(x):
    """x and doubles beside it, from the next one to a few per cent away."""
    found = [x]
    for side in (-math.inf, math.inf):
        y = math.nextafter(x, side)
        found += [y, math.nextafter(y, side)]
        for bits in (40, 26, 12, 5):
            found.append(x + math.copysign(2.0 ** -bits * max(abs(x), 1.0), side) * 1.37)
    return found


def spread(low, high, count, rng):
    """Numbers of evenly spread logarithm."""
    return [math.exp(rng.uniform(math.log(low), math.log(high))) for _ in range(count)]


def both_signs(numbers):
    return [s * x for x in numbers for s in (1, -1)]


def reals(limit, rng, special=(), count=24):
    points = [0.0] + both_signs([TINY, 1e-310, LEAST, 1e-200, 1e-100, 1e-30, limit])
    points += both_signs(spread(1e-20, 0.1, 10, rng) + spread(0.1, min(limit, 30.0), count, rng))
    if limit > 30:
        points += both_signs(spread(30.0, limit, 10, rng))
    for x in special:
        points += neighbours(x)
    return points


def positives(rng, special=()):
    points = [TINY, 1e-310, LEAST, 1e-200, 1e-100, 1e100, 1e200, 1e300, MOST]
    points += spread(1e-300, 1e300, 40, rng) + spread(0.1, 10.0, 40, rng)
    for x in special:
        points += [abs(y) for y in neighbours(x)]
    return points


def derivatives_of_one(f, x, scale):
    h = STEP * scale
    below, here, above = f(x - h), f(x), f(x + h)
    far_below, far_above = f(x - 2 * h), f(x + 2 * h)
    return [here, (above - below) / (2 * h), (above - 2 * here + below) / h**2,
            (far_above - 2 * above + 2 * below - far_below) / (2 * h**3)]


def derivatives_of_two(f, x, y, scale_x, scale_y):
    dx, dy = STEP * scale_x, STEP * scale_y
    along_x = derivatives_of_one(lambda v: f(v, y), x, scale_x)
    along_y = derivatives_of_one(lambda v: f(x, v), y, scale_y)
    mixed = (f(x + dx, y + dy) - f(x + dx, y - dy) - f(x - dx, y + dy) + f(x - dx, y - dy)) / (4 * dx * dy)
    return [along_x[0], along_x[1], along_y[1], along_x[2], mixed, along_y[2], along_x[3], along_y[3]]


def sigmoid(x):
    return 1 / (1 + mp.exp(-x))


def polygammas(x, first):
    """psi of orders first, first + 1 ..., at a smaller precision, which 2^-1100 of a root does not exhaust."""
    return [mp.psi(n, x) if n >= 0 else mp.re(mp.loggamma(x)) for n in range(first, first + 4)]


def gamma_series(x):
    g, (p0, p1, p2) = mp.gamma(x), [mp.psi(n, x) for n in range(3)]
    return [g, g * p0, g * (p0**2 + p1), g * (p0**3 + 3 * p0 * p1 + p2)]


def one(*_):
    return mpf(1)


def size(x):
    return abs(x)


def functions_of_one(rng):
    """Name, function, distance to the nearest singularity, points."""
    unit = [x for x in reals(0.999, rng) if abs(x) < 1] + [s * math.nextafter(1, 0) for s in (1, -1)]
    unit += [s * (1 - 2.0**-k * 1.1) for s in (1, -1) for k in (5, 12, 26, 40, 50)]
    roots = spread(1e-300, 1e300, 40, rng)
    angles = reals(1e5, rng, (math.pi / 2, math.pi, -math.pi / 4), 16) + [1e22, 1e300, -MOST]
    anywhere = reals(100.0, rng, (1.0, -1.0)) + both_signs([1e10, 1e20, 1e100, 1e160, 1e300, MOST])
    yield "exp", mp.exp, one, reals(709.0, rng) + [-745.0, -744.4, -710.0, 709.78]
    yield "exp2", lambda x: mpf(2) ** x, one, reals(1020.0, rng) + [-1074.0, -1050.5]
    yield "exp10", lambda x: mpf(10) ** x, one, reals(307.0, rng) + [-323.0, -310.5]
    yield "expm1", mp.expm1, one, reals(709.0, rng) + [-745.0, -50.0]
    for name, base in (("log", None), ("log2", 2), ("log10", 10)):
        ln = mp.log(base) if base else mpf(1)
        yield name, lambda x, ln=ln: mp.log(x) / ln, size, positives(rng, (1.0,))
    yield "log1p", lambda x: mp.log(1 + x), lambda x: 1 + x, [
        x for x in reals(1e5, rng, (-0.5,)) if x > -1] + [math.nextafter(-1, 0), -0.9999, 1e100, MOST]
    yield "sigmoid", sigmoid, one, reals(745.0, rng, (1.3169578969248166,))
    yield "softplus", lambda x: mp.log(1 + mp.exp(x)), one, reals(745.0, rng)
    yield "sin", mp.sin, one, angles
    yield "cos", mp.cos, one, angles
    yield "tan", mp.tan, lambda x: min(mpf(1), abs(mp.cos(x))), angles
    yield "asin", mp.asin, lambda x: 1 - abs(x), unit
    yield "acos", mp.acos, lambda x: 1 - abs(x), unit
    yield "atan", mp.atan, lambda x: max(mpf(1), abs(x)), anywhere
    yield "sinh", mp.sinh, one, reals(710.0, rng)
    yield "cosh", mp.cosh, one, reals(710.0, rng)
    yield "tanh", mp.tanh, one, reals(372.0, rng, (0.5493061443340549, 0.6584789484624083))
    yield "asinh", mp.asinh, lambda x: max(mpf(1), abs(x)), anywhere
    yield "acosh", mp.acosh, lambda x: x - 1, [
        x for x in neighbours(1.0) + spread(1.0, 10.0, 40, rng) + spread(10.0, 1e300, 30, rng) if x > 1] + [MOST]
    yield "atanh", mp.atanh, lambda x: 1 - abs(x), unit
    yield "square", lambda x: x * x, size, both_signs(roots) + [TINY]
    yield "reciprocal", lambda x: 1 / x, size, both_signs(roots) + [TINY, LEAST, MOST]
    yield "sqrt", mp.sqrt, size, positives(rng, (1.0,))
    yield "cbrt", lambda x: mp.sign(x) * mp.cbrt(abs(x)), size, both_signs(positives(rng)[:80]) + [-1.0, 1.0]
    yield "erf", mp.erf, one, reals(26.6, rng, (0.7071067811865476,))
    yield "erfc", mp.erfc, one, reals(26.6, rng, (0.7071067811865476,))


def functions_of_gamma(rng):
    near = [x for r in (1.0, 2.0, 1.4616321449683622, -0.5, -0.504083008264455) for x in neighbours(r)]
    positive = [1e-300, 1e-100, 1e-20, 1e-8] + spread(1e-3, 20.0, 40, rng) + spread(20.0, 170.0, 10, rng)
    negative = [-x for x in spread(1e-3, 20.0, 24, rng)] + [-1e-8, -1e-100, -99.25]
    # Beside the integers below 0 the argument's distance to them decides: leave room for it.
    everywhere = near + positive + [x for x in negative if x > -1 or abs(x - round(x)) > 1e-3]
    yield "lgamma", lambda x: polygammas(x, -1), everywhere + [1e10, 1e300]
    yield "tgamma", gamma_series, everywhere
    yield "digamma", lambda x: polygammas(x, 0), everywhere + [1e10, 1e100]
    yield "trigamma", lambda x: polygammas(x, 1), everywhere + [1e10]


def pairs(rng, count=70):
    """Pairs at ties, on the axes' sides, of all sizes and of equal sizes."""
    points = []
    for x in spread(1e-150, 1e150, 8, rng):
        points += [(x, x), (x, -x), (-x, math.nextafter(x, 1)), (x, x * (1 + 2.0**-30))]
    for _ in range(count):
        x, y = spread(0.01, 100.0, 2, rng)
        points.append((x * rng.choice((1, -1)), y * rng.choice((1, -1))))
    for _ in range(count // 2):
        x, y = spread(1e-150, 1e150, 2, rng)
        points.append((x * rng.choice((1, -1)), y * rng.choice((1, -1))))
    return points + [(1e-166, 1.0), (1.0, 1e-166), (-1e-300, 2.0), (3e300, -4e300), (1.5e308, 1.5e308),
                     (TINY, TINY), (TINY, 1.0), (1.0, TINY), (3e-320, -4e-320), (1e-310, 1e-305)]


def functions_of_two(rng):
    def radius(x, y):
        r = mp.hypot(x, y)
        return r, r

    differences = [(x + y, x) for x in (0.0, 1.0, -3.5, 600.25, 1e5) for y in reals(700.0, rng, (), 3)]
    bases = spread(1e-5, 1e5, 60, rng) + [1.0, math.nextafter(1, 2), math.nextafter(1, 0), 2.0]
    exponents = [0.0, 0.5, 1.0, 1.0000001, 2.0, 3.0, -1.0, -2.5, 10.25, 1e-20, 25.0]
    powers = [(x, rng.choice(exponents)) for x in bases] + [(x, rng.uniform(-20, 20)) for x in bases]
    powers += [(TINY, 0.5), (TINY, 0.9), (1e-310, 0.25), (MOST, 1.0), (MOST, 0.5), (1e-200, 1.7),
               (1e-200, 2.0), (1e300, 1.02), (1e300, 0.01), (1e308, 1.0), (0.5, 1000.0), (1 - 2.0**-30, 1e10)]
    yield "logsumexp", lambda x, y: x + mp.log(1 + mp.exp(y - x)), lambda x, y: (1, 1), differences
    yield "divide", lambda x, y: x / y, lambda x, y: (abs(y), abs(y)), [(x, y) for x, y in pairs(rng) if y]
    yield "hypot", mp.hypot, radius, pairs(rng)
    yield "hypot3", lambda x, y: mp.sqrt(x * x + y * y + 4), lambda x, y: (2, 2), pairs(rng)
    # Nearer to the cut, where the angle jumps, a step would cross it.
    yield "atan2", mp.atan2, radius, [(y, x) for y, x in pairs(rng) if x > 0 or abs(y) > 1e-100 * abs(x)]
    yield "pow", lambda x, y: mp.exp(y * mp.log(x)), lambda x, y: (x, min(1, 1 / abs(mp.log(x) or 1))), powers


def functions_with_jumps(rng):
    """fmod and remainder between their jumps, exactly."""
    points = [(x, y) for x, y in pairs(rng, 40) if abs(x / y) < 1e15]
    for name, rounded in (("fmod", lambda q: mp.sign(q) * mp.floor(abs(q))), ("remainder", mp.nint)):
        rows = []
        for x, y in points:
            q = rounded(mpf(x) / mpf(y))
            rows.append(((x, y), [mpf(x) - q * mpf(y), mpf(1), -q] + [mpf(0)] * 5))
        yield name, rows


def write(out, name, count, rows):
    out.write(f"f {name} {count}\n")
    for arguments, results in sorted(set((a, tuple(map(to_double, r))) for a, r in rows)):
        out.write(" ".join(map(digits, arguments + results)) + "\n")
    print(name, len(rows), file=sys.stderr, flush=True)


def main(path):
    rng = random.Random(1)
    with open(path, "w", encoding="ascii") as out:
        for name, f, scale, points in functions_of_one(rng):
            rows = [((x,), derivatives_of_one(f, mpf(x), scale(mpf(x)) or mpf(1))) for x in points]
            write(out, name, 1, rows)
        for name, f, scale, points in functions_of_two(rng):
            rows = [((x, y), derivatives_of_two(f, mpf(x), mpf(y), *scale(mpf(x), mpf(y)))) for x, y in points]
            write(out, name, 2, rows)
        for name, rows in functions_with_jumps(rng):
            write(out, name, 2, rows)
        mp.prec = 1400
        for name, series, points in functions_of_gamma(rng):
            write(out, name, 1, [((x,), series(mpf(x))) for x in points])


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "function_table.txt")
