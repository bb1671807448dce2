#!/usr/bin/env python3
"""Least-squares cylinders of generated point sets to 45 digits, for tests/metrology.rs.

usage: metrology.py > tests/data/metrology.json         (needs mpmath; minutes, with gmpy2 fewer)
       metrology.py --points NAME > NAME.ds             (x y z of a set, a point a line)

A set is a seed and a few numbers; `points` makes its coordinates with additions, multiplications and divisions alone, so that
every machine and language gets the same bits. `solve` minimises the sum of squared distances to the surface by Newton's
method with 60 digits. It shares nothing with the library: its unknowns are where the axis meets a plane (a, b), its slopes
(u, v) and the radius, its derivatives are those below, and coordinates are the exact values of the doubles.
"""
import json
import math
import sys

import mpmath
from mpmath import mpf

DIGITS = 60
MASK = (1 << 64) - 1
# Above this many points the matrix of Newton's method is one of doubles; steps are corrected until they are as small.
LARGE = 2000


class Stream:
    """SplitMix64 (Steele, Lea, Flood, OOPSLA 2014)."""

    def __init__(self, seed):
        self.state = seed

    def next(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) & MASK
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        return z ^ (z >> 31)

    def unit(self):
        """Uniform in [0, 1)."""
        return (self.next() >> 11) * 2.0**-53

    def choose(self, values):
        return values[self.next() % len(values)]


def rotation(quaternion):
    """Nine integers and what they are to be divided by."""
    w, x, y, z = quaternion
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return rows, w * w + x * x + y * y + z * z


def points(case):
    """The coordinates of a set, as doubles."""
    stream = Stream(case["seed"])
    rows, norm = rotation(case["quaternion"])
    rows = [[float(entry) / float(norm) for entry in row] for row in rows]
    radius, half, arc = case["radius"], case["half_length"], case["arc"]
    oval, lobes, barrel, noise = case["oval"], case["lobes"], case["barrel"], case["noise"]
    offset = case["offset"]
    made = []
    for _ in range(case["points"]):
        t = arc * (2.0 * stream.unit() - 1.0)
        along = 2.0 * stream.unit() - 1.0
        error = ((stream.unit() + stream.unit()) + (stream.unit() + stream.unit())) - 2.0
        behind = stream.unit() < 0.5
        c = (1.0 - t * t) / (1.0 + t * t)
        s = (2.0 * t) / (1.0 + t * t)
        if case["full"] and behind:
            c = -c
        form = (oval * (2.0 * c * c - 1.0) + lobes * ((4.0 * c * c - 3.0) * c)) + (barrel * (along * along) + noise * error)
        distance = radius + form
        x, y, z = distance * c, distance * s, half * along
        made.append(tuple(((row[0] * x + row[1] * y) + row[2] * z) + shift for row, shift in zip(rows, offset)))
    return made


def evaluate(local, parameters, root, hessian):
    """Half the sum of squares, its gradient and, if wanted, its matrix of second derivatives, of a, b, u, v, r."""
    a, b, u, v, r = parameters
    n = u * u + v * v + 1
    zero = r - r
    cost, gradient = zero, [zero] * 5
    matrix = [[zero] * 5 for _ in range(5)]
    squares = [[zero] * 5 for _ in range(5)]
    for x, y, z in local:
        qx, qy = x - a, y - b
        k = (qx * u + qy * v + z) / n
        ex, ey, ez = qx - k * u, qy - k * v, z - k
        g = root(ex * ex + ey * ey + ez * ez)
        f = g - r
        first = [-ex / g, -ey / g, -k * ex / g, -k * ey / g]
        cost += f * f
        for i in range(4):
            gradient[i] += f * first[i]
        gradient[4] -= f
        if not hessian:
            continue
        ku, kv = (qx - 2 * u * k) / n, (qy - 2 * v * k) / n
        exs = [u * u / n - 1, u * v / n, -k - u * ku, -u * kv]
        eys = [u * v / n, v * v / n - 1, -v * ku, -k - v * kv]
        # Half the second derivatives of the squared distance g².
        half = [
            [-e for e in exs],
            [-e for e in eys],
            [-exs[2], -eys[2], -(ku * ex + k * exs[2]), -(kv * ex + k * exs[3])],
            [-exs[3], -eys[3], -(kv * ex + k * exs[3]), -(kv * ey + k * eys[3])],
        ]
        for i in range(4):
            for j in range(4):
                product = first[i] * first[j]
                squares[i][j] += product
                matrix[i][j] += product + f * (half[i][j] - product) / g
            matrix[i][4] -= first[i]
            matrix[4][i] -= first[i]
            squares[i][4] -= first[i]
            squares[4][i] -= first[i]
        matrix[4][4] += 1
        squares[4][4] += 1
    return cost / 2, gradient, matrix, squares


def damped(local, start, size):
    """Levenberg and Marquardt in doubles, from the nominal cylinder to near the minimum."""
    parameters, damping = start, 1e-6
    cost, gradient, matrix, squares = evaluate(local, parameters, math.sqrt, True)
    for _ in range(200):
        weighted = mpmath.matrix(squares)
        for i in range(5):
            weighted[i, i] += damping * weighted[i, i]
        step = mpmath.lu_solve(weighted, -mpmath.matrix(gradient))
        trial = [float(value + change) for value, change in zip(parameters, step)]
        new = evaluate(local, trial, math.sqrt, True)
        if new[0] < cost:
            small = max(abs(float(change)) for change in step) < 1e-13 * size
            parameters, damping = trial, damping / 10
            cost, gradient, matrix, squares = new
            if small:
                break
        else:
            damping = max(damping, 1e-12) * 10
            if damping > 1e8:
                break
    return parameters


def solve(case):
    """The answer of a set; None where it has no clear minimum near the nominal cylinder."""
    world = points(case)
    rows, norm = rotation(case["quaternion"])
    offset = [mpf(x) for x in case["offset"]]
    # Into the frame of the nominal cylinder, exactly but for the last digits.
    local = []
    for point in world:
        shifted = [mpf(x) - o for x, o in zip(point, offset)]
        local.append(tuple(sum(rows[i][j] * shifted[i] for i in range(3)) / norm for j in range(3)))
    size = max(case["radius"], case["half_length"])
    rough = damped([tuple(float(x) for x in point) for point in local], [0.0, 0.0, 0.0, 0.0, case["radius"]], size)
    if not abs(rough[4] / case["radius"] - 1.0) < 0.5 or max(map(abs, rough[2:4])) > 0.5:
        return None
    parameters = [mpf(value) for value in rough]
    fixed = None
    if len(local) > LARGE:
        near = [tuple(float(x) for x in point) for point in local]
        _, _, matrix, squares = evaluate(near, rough, math.sqrt, True)
        fixed = mpmath.matrix(matrix)
    for _ in range(30):
        cost, gradient, matrix, own = evaluate(local, parameters, mpmath.sqrt, fixed is None)
        if fixed is None:
            squares = own
        step = mpmath.lu_solve(mpmath.matrix(matrix) if fixed is None else fixed, -mpmath.matrix(gradient))
        parameters = [value + change for value, change in zip(parameters, step)]
        largest = max(abs(change) for change in step)
        if largest < mpf(10) ** -50 * size:
            break
        if not largest < size:
            return None
    else:
        return None
    # The condition of the Jacobian, lengths and slopes in units of the size.
    units = [1, 1, 1 / mpf(size), 1 / mpf(size), 1]
    scaled = mpmath.matrix(5, 5)
    for i in range(5):
        for j in range(5):
            scaled[i, j] = squares[i][j] * units[i] * units[j]
    values = sorted(mpmath.eigsy(scaled, eigvals_only=True))
    minimum = mpmath.matrix(matrix if fixed is None else fixed.tolist())
    if not values[0] > 0 or not min(mpmath.eigsy(minimum, eigvals_only=True)) > 0:
        return None
    condition = mpmath.sqrt(values[4] / values[0])
    if condition > 1e6:
        return None
    a, b, u, v, r = parameters
    length = mpmath.sqrt(u * u + v * v + 1)
    turned = lambda vector: [sum(rows[i][j] * vector[j] for j in range(3)) / norm for i in range(3)]
    point = [o + x for o, x in zip(offset, turned([a, b, mpf(0)]))]
    direction = [x / length for x in turned([u, v, mpf(1)])]
    rms = mpmath.sqrt(2 * cost / len(local))
    text = lambda value: mpmath.nstr(value, 45, min_fixed=-10, max_fixed=10)
    return {
        "point": [text(x) for x in point],
        "direction": [text(x) for x in direction],
        "radius_fitted": text(r),
        "rms": text(rms),
        "condition": float(mpmath.nstr(condition, 4)),
    }


# Tangents of a quarter of the arc: full circle, 180, 120, 90, 60, 30, 15 and 8 degrees.
ARCS = [(1.0, True), (1.0, False), (0.57735, False), (0.41421, False), (0.26795, False), (0.13165, False), (0.06554, False),
        (0.03492, False)]


def cases():
    """The sets: those of each arc in turn, and a few large ones."""
    stream = Stream(20_260_307)
    made = []
    plan = [(arc, count) for count in [5, 6, 7, 8, 10, 12, 15, 20, 30, 50, 75, 100] for arc in ARCS for _ in range(3)]
    plan += [(arc, count) for count in [150, 300, 1000] for arc in ARCS]
    plan += [(ARCS[0], 10_000), (ARCS[2], 10_000), (ARCS[5], 10_000), (ARCS[2], 100_000)]
    for arc, count in plan:
        made.append(case_of(stream, arc, count))
    return made


def case_of(stream, arc, count):
    tangent, full = arc
    radius = stream.choose([0.004, 0.02, 0.05, 0.3, 2.0])
    # The height of the arc: errors must leave it recognisable.
    height = radius * (2.0 * tangent * tangent / (1.0 + tangent * tangent)) * (2.0 if full else 1.0)
    form = stream.choose(["none", "none", "oval", "lobes", "barrel"])
    share = height * stream.choose([1e-4, 1e-3, 1e-2]) if form != "none" else 0.0
    # So few points are fitted exactly or nearly so: large errors would leave several cylinders.
    noise = height * stream.choose([1e-6, 1e-4, 1e-3] if count < 10 else [1e-6, 1e-4, 1e-2])
    return {
        "seed": stream.next() >> 12,
        "points": count,
        "radius": radius,
        "half_length": radius * stream.choose([0.5, 1.0, 3.0, 10.0]),
        "arc": tangent,
        "full": full,
        "oval": share if form == "oval" else 0.0,
        "lobes": share if form == "lobes" else 0.0,
        "barrel": share if form == "barrel" else 0.0,
        "noise": noise,
        "quaternion": [int(stream.next() % 19) - 9, int(stream.next() % 19) - 9, int(stream.next() % 19) - 9, 10],
        "offset": stream.choose([[0.0, 0.0, 0.0], [0.3, -0.2, 0.9], [31.0, -47.5, 12.25], [1000.0, -512.125, 333.0]]),
    }


def main():
    mpmath.mp.dps = DIGITS
    if sys.argv[1:2] == ["--points"]:
        case = next(case for index, case in enumerate(cases()) if f"set{index:03}" == sys.argv[2])
        for point in points(case):
            print(*map(repr, point))
        return
    lines = []
    for index, case in enumerate(cases()):
        answer = solve(case)
        print(f"set{index:03} {case['points']} points: {'no clear minimum' if answer is None else answer['condition']}", file=sys.stderr)
        if answer is not None:
            lines.append(json.dumps({"name": f"set{index:03}", **case, **answer}))
    print("[\n" + ",\n".join(lines) + "\n]")


if __name__ == "__main__":
    main()
