#!/usr/bin/env python3
"""Draws the figures of the concepts as SVG: python3 docs/drawings/draw.py FOLDER (docs/images).

Needs nothing but Python. The geometry is computed, not sketched: limbs, walls and arcs are where a camera would see them.
`tests/docs.sh` checks that the files in docs/images are what this prints.
"""

import math
import pathlib
import random
import sys

BLUE, RED, GREEN, GREY, INK, FILL = "#1f6fb2", "#c8374b", "#1e8a50", "#8a96a3", "#222222", "#dbe7f3"


class Drawing:
    """A white sheet of 480 units' width, so that its text of 16 units can be read on a phone."""

    def __init__(self, height, title, width=480):
        self.width, self.height, self.title, self.parts = width, height, title, []

    def add(self, text):
        self.parts.append(text)

    def line(self, points, colour=INK, width=2.0, dash=None, fill="none", closed=False, opacity=None):
        path = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points) + (" Z" if closed else "")
        extra = f' stroke-dasharray="{dash}"' if dash else ""
        extra += f' opacity="{opacity}"' if opacity else ""
        self.add(f'<path d="{path}" fill="{fill}" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"{extra}/>')

    def arrow(self, start, end, colour=INK, width=2.0):
        angle = math.atan2(end[1] - start[1], end[0] - start[0])
        back = [(end[0] - 11 * math.cos(angle + s * 0.4), end[1] - 11 * math.sin(angle + s * 0.4)) for s in (1, -1)]
        shaft = (end[0] - 8 * math.cos(angle), end[1] - 8 * math.sin(angle))
        self.line([start, shaft], colour, width)
        self.line([end, *back], colour, 0.5, fill=colour, closed=True)

    def dot(self, point, colour=INK, radius=4.0):
        self.add(f'<circle cx="{point[0]:.1f}" cy="{point[1]:.1f}" r="{radius}" fill="{colour}"/>')

    def box(self, x, y, width, height, colour=INK, fill="none", radius=6, dash=None):
        extra = f' stroke-dasharray="{dash}"' if dash else ""
        self.add(f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="{radius}" fill="{fill}" stroke="{colour}"'
                 f' stroke-width="1.5"{extra}/>')  # fmt: skip

    def text(self, x, y, text, colour=INK, anchor="start", size=16, weight="normal"):
        self.add(f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" font-size="{size}"'
                 f' font-weight="{weight}">{text}</text>')  # fmt: skip

    def save(self, path):
        head = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}"'
                f' height="{self.height}" font-family="Helvetica, Arial, sans-serif" role="img">')  # fmt: skip
        sheet = f'<rect width="{self.width}" height="{self.height}" rx="10" fill="#ffffff"/>'
        path.write_text("\n".join([head, f"<title>{self.title}</title>", sheet, *self.parts, "</svg>"]) + "\n")


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def scaled(a, s):
    return [x * s for x in a]


def added(*vectors):
    return [sum(x) for x in zip(*vectors)]


def unit(a):
    return scaled(a, 1 / math.sqrt(dot(a, a)))


class Cylinder:
    """A cylinder seen by a camera at the origin: middle, unit direction, radius, half length."""

    def __init__(self, middle, direction, radius, half):
        self.middle, self.direction, self.radius, self.half = middle, unit(direction), radius, half
        self.foot = added(middle, scaled(self.direction, -dot(middle, self.direction)))
        self.away = unit(self.foot)
        self.side = cross(self.direction, self.away)
        self.limb_angle = math.acos(radius / math.sqrt(dot(self.foot, self.foot)))

    def point(self, angle, along):
        """On the surface; angle 0 faces the camera, the limbs are at plus and minus `limb_angle`."""
        across = added(scaled(self.away, -math.cos(angle)), scaled(self.side, math.sin(angle)))
        return added(self.middle, scaled(self.direction, along), scaled(across, self.radius))

    def circle(self, along, start, end, count=60):
        return [self.point(start + (end - start) * k / count, along) for k in range(count + 1)]


def pinhole(focal, x, y):
    return lambda p: (x + focal * p[0] / p[2], y + focal * p[1] / p[2])


def draw_body(sheet, cylinder, to_sheet, fill=FILL, clip=None):
    """The visible surface with its limbs and the near rims; the cap that is seen, if any."""
    limb, half = cylinder.limb_angle, cylinder.half
    near = [[to_sheet(p) for p in cylinder.circle(s * half, -limb, limb)] for s in (-1, 1)]
    far = [[to_sheet(p) for p in cylinder.circle(s * half, limb, 2 * math.pi - limb)] for s in (-1, 1)]
    sheet.line(near[0] + near[1][::-1], "none", 0, fill=fill, closed=True)
    return near, far


def camera_frame():
    sheet = Drawing(330, "The camera frame: x to the right, y down, z forward; a cylinder with axis, point and radius")
    # Seen obliquely: a drawing of its own coordinates, x right, y down, z into the distance to the upper right.
    def flat(p):
        return (66 + 62 * p[0] + 66 * p[2], 200 + 62 * p[1] - 13 * p[2])
    origin = flat([0, 0, 0])
    corners = [flat([x, y, 1.15]) for x, y in ((-0.75, -0.6), (0.75, -0.6), (0.75, 0.6), (-0.75, 0.6))]
    middle, direction, radius, half = [0.4, 0.2, 4.0], unit([0.3, 0.93, 0.25]), 0.6, 1.4
    u = unit(cross(direction, [0, 0, 1]))
    v = cross(direction, u)
    def rim(along, count=72):
        return [added(middle, scaled(direction, along), scaled(u, radius * math.cos(t)), scaled(v, radius * math.sin(t)))
                for t in (2 * math.pi * k / count for k in range(count + 1))]  # fmt: skip
    rims = [[flat(p) for p in rim(s * half)] for s in (-1, 1)]
    # The outline in this drawing: the two tangents along the direction, the outermost points across it.
    along = [flat(added(middle, direction))[k] - flat(middle)[k] for k in (0, 1)]
    across = lambda q: q[0] * along[1] - q[1] * along[0]
    ends = [[max(r, key=across), min(r, key=across)] for r in rims]
    sheet.line([ends[0][0], ends[1][0], ends[1][1], ends[0][1]], "none", 0, fill=FILL, closed=True)
    for r in rims:
        sheet.line(r, BLUE, 1.5, fill=FILL, closed=True)
    for k in (0, 1):
        sheet.line([ends[0][k], ends[1][k]], BLUE, 2)
    for corner in corners:
        sheet.line([origin, corner], GREY, 1)
    sheet.line(corners, GREY, 1.5, closed=True, fill="#ffffff", opacity=0.85)
    sheet.arrow(origin, flat([1.15, 0, 0]), INK)
    sheet.arrow(origin, flat([0, 1.35, 0]), INK)
    sheet.arrow(origin, flat([0, 0, 2.6]), INK)
    sheet.dot(origin)
    x, y = flat([1.15, 0, 0])
    sheet.text(x - 6, y + 20, "x")
    x, y = flat([0, 1.35, 0])
    sheet.text(x + 8, y + 2, "y")
    x, y = flat([0, 0, 2.6])
    sheet.text(x - 6, y + 22, "z")
    axis = [flat(added(middle, scaled(direction, s * half * 1.35))) for s in (-1, 1)]
    sheet.line(axis, INK, 1.5, dash="9 4 2 4")
    sheet.arrow(flat(middle), flat(added(middle, scaled(direction, 0.75))), RED, 2.5)
    sheet.dot(flat(middle), RED)
    x, y = flat(added(middle, scaled(direction, 0.75)))
    sheet.text(x + 8, y + 2, "direction", RED)
    x, y = flat(middle)
    sheet.text(x - 10, y - 6, "point", RED, "end")
    edge = flat(added(middle, scaled(direction, -half)))
    out = max(ends[0])
    sheet.line([edge, out], RED, 2)
    sheet.text(out[0] + 8, out[1] + 4, "radius", RED)
    sheet.text(4, 222, "camera", INK)
    sheet.text(corners[0][0] - 4, corners[0][1] - 8, "image", GREY)
    return sheet


def section():
    sheet = Drawing(300, "A section across the axis: two rays touch the surface at the limbs, which part near and far wall")
    eye, middle, radius = (38.0, 150.0), (335.0, 150.0), 95.0
    gamma = math.asin(radius / (middle[0] - eye[0]))
    limb = math.pi / 2 - gamma  # from the direction towards the camera
    def on(angle, r=radius):
        return (middle[0] - r * math.cos(angle), middle[1] - r * math.sin(angle))
    near = [on(-limb + 2 * limb * k / 60) for k in range(61)]
    far = [on(limb + (2 * math.pi - 2 * limb) * k / 60) for k in range(61)]
    sheet.line(far, GREY, 2.5, dash="7 5", fill="#f6f8fa")
    sheet.line(near, BLUE, 5)
    for s in (-1, 1):
        touch = on(s * limb)
        beyond = (eye[0] + (touch[0] - eye[0]) * 1.3, eye[1] + (touch[1] - eye[1]) * 1.3)
        sheet.line([eye, beyond], RED, 1.5)
        sheet.line([middle, touch], INK, 1.2, dash="3 3")
        sheet.dot(touch, RED, 5)
    sheet.line([eye, middle], INK, 1.2, dash="9 4 2 4")
    sheet.dot(eye)
    sheet.dot(middle)
    arc = [(eye[0] + 95 * math.cos(t), eye[1] - 95 * math.sin(t)) for t in (gamma * k / 20 for k in range(21))]
    sheet.line(arc, INK, 1.5)
    sheet.text(eye[0] + 101, eye[1] - 11, "γ", INK, size=18)
    sheet.text(eye[0] - 26, eye[1] + 28, "camera")
    sheet.text(middle[0] + 8, middle[1] + 20, "axis")
    sheet.text(middle[0] - 26, middle[1] - 42, "r", INK, "end", 18)
    sheet.text(on(limb)[0] - 12, on(limb)[1] - 14, "limb", RED, "end")
    sheet.text(on(-limb)[0] - 12, on(-limb)[1] + 24, "limb", RED, "end")
    sheet.text(middle[0] - radius - 8, middle[1] - 10, "near wall", BLUE, "end")
    sheet.text(middle[0] + 16, middle[1] - 24, "far wall", "#5f6b77")
    return sheet


def in_the_image():
    sheet = Drawing(400, "A cylinder in the image: two limb lines, the arc of each end, a cap")
    can = Cylinder([0.0, 0.0, 1.0], [0.16, 0.80, -0.45], 0.22, 0.3)
    to_sheet = pinhole(400, 215, 185)
    near, far = draw_body(sheet, can, to_sheet)
    # The upper end turns away from the camera here: its far rim is hidden. The lower end shows its cap or its inside.
    facing = [dot(scaled(can.direction, s), added(can.middle, scaled(can.direction, s * can.half))) < 0 for s in (-1, 1)]
    for k in (0, 1):
        if facing[k]:
            sheet.line(near[k] + far[k], "none", 0, fill="#eef1f4", closed=True)
            sheet.line(far[k], GREY, 2.5, dash="7 5")
    for s in (-1, 1):
        ends = [to_sheet(can.point(s * can.limb_angle, along * can.half)) for along in (-1.22, 1.22)]
        sheet.line(ends, RED, 1.2, dash="5 4")
        sheet.line([to_sheet(can.point(s * can.limb_angle, along * can.half)) for along in (-1, 1)], RED, 3.5)
    for k in (0, 1):
        sheet.line(near[k], GREEN, 3.5)
    for angle in (-0.55, 0.1, 0.7):
        sheet.line([to_sheet(can.point(angle, along * can.half)) for along in (-1, 1)], BLUE, 0.8)
    axis = [to_sheet(added(can.middle, scaled(can.direction, s * can.half * 1.3))) for s in (-1, 1)]
    sheet.line(axis, INK, 1.2, dash="9 4 2 4")
    left = min((to_sheet(can.point(s * can.limb_angle, 0)) for s in (-1, 1)))
    right = max((to_sheet(can.point(s * can.limb_angle, 0)) for s in (-1, 1)))
    sheet.text(left[0] - 14, left[1] - 4, "limb", RED, "end")
    sheet.text(left[0] - 14, left[1] + 15, "line", RED, "end")
    sheet.text(right[0] + 14, right[1] + 4, "limb line", RED)
    top, bottom = sorted(near, key=lambda rim: rim[30][1])
    sheet.text(12, 42, "arc of an end", GREEN)
    sheet.line([(112, 48), (top[22][0], top[22][1] - 3)], GREEN, 1)
    sheet.text(355, 338, "arc of an", GREEN)
    sheet.text(355, 357, "end: near rim", GREEN)
    sheet.line([(352, 340), bottom[50] if bottom[50][0] > bottom[10][0] else bottom[10]], GREEN, 1)
    rim = max(far, key=lambda r: r[30][1])
    sheet.text(12, 372, "far rim, beyond a cap", "#5f6b77")
    sheet.line([(120, 356), rim[30]], GREY, 1)
    sheet.text(330, 42, "generators:", BLUE)
    sheet.text(330, 61, "lines along", BLUE)
    sheet.text(330, 80, "the surface", BLUE)
    return sheet


def two_sources():
    sheet = Drawing(330, "Depth is metric but off near the limbs; the limbs in the image are sharp but know no scale")
    random.seed(3)
    eye, middle, radius = (34.0, 140.0), (330.0, 140.0), 88.0
    gamma = math.asin(radius / (middle[0] - eye[0]))
    limb = math.pi / 2 - gamma
    def on(angle, r=radius):
        return (middle[0] - r * math.cos(angle), middle[1] - r * math.sin(angle))
    sheet.line([on(-limb + 2 * limb * k / 60) for k in range(61)], BLUE, 2)
    # Two more circles between the same two rays: the limbs alone cannot tell them apart.
    for factor, label in ((0.72, None), (1.2, None)):
        centre = (eye[0] + (middle[0] - eye[0]) * factor, middle[1])
        ring = [(centre[0] - radius * factor * math.cos(t), centre[1] - radius * factor * math.sin(t))
                for t in (2 * math.pi * k / 80 for k in range(81))]  # fmt: skip
        sheet.line(ring, RED, 1.2, dash="3 4", opacity=0.8)
    for s in (-1, 1):
        touch = on(s * limb)
        sheet.line([eye, (eye[0] + (touch[0] - eye[0]) * 1.55, eye[1] + (touch[1] - eye[1]) * 1.55)], RED, 1.8)
    for k in range(95):
        angle = (random.random() * 2 - 1) * limb * 1.0
        steep = abs(angle) / limb
        bias = -75 * (max(0.0, steep - 0.7) / 0.3) ** 2 + random.gauss(0, 3.0)
        p = on(angle)
        ray = math.atan2(p[1] - eye[1], p[0] - eye[0])
        sheet.dot((p[0] - bias * math.cos(ray), p[1] - bias * math.sin(ray)), INK, 2)
    sheet.dot(eye)
    sheet.text(12, 170, "camera")
    sheet.text(16, 30, "limbs: sharp, but every circle", RED)
    sheet.text(16, 50, "between the two rays fits them", RED)
    sheet.text(16, 284, "depth: tells the distance, but is noisy, and")
    sheet.text(16, 304, "smeared, bent or missing towards the limbs")
    return sheet


def end_states():
    sheet = Drawing(560, "The four states of an end: seen, cut by the border, hidden, unknown")
    names = [("seen", "what lies beyond is", "farther: it ends there", BLUE), ("cut", "the border of the", "image cuts it off", BLUE),
             ("hidden", "something nearer", "covers the rest", BLUE), ("unknown", "no depth beyond", "the end", BLUE)]  # fmt: skip
    for index, (name, first, second, _) in enumerate(names):
        x, y = 12 + 234 * (index % 2), 12 + 274 * (index // 2)
        sheet.box(x, y, 222, 170, GREY, "#f3efe6", 3)
        can = Cylinder([0, 0, 1.0], [1, 0.16, 0.12], 0.16, 0.34)
        shift = {"cut": 175, "hidden": 150}.get(name, 100)
        sheet.add(f'<clipPath id="{name}"><rect x="{x}" y="{y}" width="222" height="170"/></clipPath><g clip-path="url(#{name})">')
        if name == "unknown":
            sheet.box(x + 130, y, 92, 170, "none", "#4b5158", 0)
        near, far = draw_body(sheet, can, pinhole(220, x + shift, y + 82))
        for s in (-1, 1):
            to_sheet = pinhole(220, x + shift, y + 82)
            sheet.line([to_sheet(can.point(s * can.limb_angle, a * can.half)) for a in (-1, 1)], RED, 3)
        for rim in near:
            sheet.line(rim, GREEN, 3)
        if name == "hidden":
            sheet.line([(x + 165, y - 5), (x + 245, y - 5), (x + 225, y + 175), (x + 145, y + 175)], "#7a5c3e", 1.5, fill="#c9a67e",
                       closed=True)  # fmt: skip
        sheet.add("</g>")
        if name == "unknown":
            sheet.text(x + 214, y + 24, "no depth", "#ffffff", "end", 14)
        sheet.text(x, y + 194, name, INK, size=18, weight="bold")
        sheet.text(x, y + 215, first)
        sheet.text(x, y + 235, second)
    return sheet


def uncertainty():
    sheet = Drawing(470, "A result with its standard deviation, two radii that agree or not, and a verdict on a tolerance")
    def bell(x, y, sigma, height, colour):
        points = [(x + 3.2 * sigma * k / 40, y - height * math.exp(-0.5 * (3.2 * k / 40) ** 2)) for k in range(-40, 41)]
        sheet.line(points, colour, 2.2, fill=colour + "22")
        sheet.line([(x, y), (x, y - height)], colour, 1, dash="3 3")
    sheet.text(16, 28, "Two estimates of one radius that agree:", weight="bold")
    sheet.line([(16, 130), (464, 130)], GREY, 1.5)
    bell(215, 130, 46, 48, INK)
    bell(262, 130, 15, 78, RED)
    sheet.text(70, 92, "by the points")
    sheet.text(300, 70, "by the limbs", RED)
    sheet.text(16, 176, "More than 4 deviations apart: a warning", weight="bold")
    sheet.line([(16, 268), (464, 268)], GREY, 1.5)
    bell(130, 268, 30, 58, INK)
    bell(340, 268, 14, 78, RED)
    sheet.line([(130, 282), (340, 282)], GREY, 1.5)
    sheet.text(235, 300, "POINTS_AND_LIMBS_DISAGREE", INK, "middle", 14)
    sheet.text(16, 340, "A tolerance, and what may be said of it:", weight="bold")
    sheet.box(120, 352, 200, 88, GREEN, "#e5f4ea", 0)
    for y, x, word in ((372, 210, "pass"), (397, 300, "undecided"), (422, 384, "fail")):
        sheet.line([(x - 32, y), (x + 32, y)], INK, 2)
        for s in (-32, 32):
            sheet.line([(x + s, y - 6), (x + s, y + 6)], INK, 2)
        sheet.dot((x, y))
        sheet.text(16, y + 5, word)
    sheet.text(220, 460, "tolerance", GREEN, "middle", 14)
    return sheet


def stages():
    sheet = Drawing(430, "The stages of a fit, from depth, mask, edges and image to the result")
    rows = [("start", "rough cylinders; the best one is kept", BLUE), ("first fit", "points, and edges or mask sides as hints", BLUE),
            ("limbs", "located in the image to a fraction of a pixel", RED), ("fit", "points and located limb lines", BLUE),
            ("ends", "their arcs in the image steady the tilt", GREEN), ("last fit", "to the tolerances asked for", BLUE),
            ("result", "cylinder, covariance, warnings, extent", INK)]  # fmt: skip
    sheet.text(240, 30, "depth and mask · edges · image", INK, "middle", weight="bold")
    for index, (name, words, colour) in enumerate(rows):
        y = 44 + 55 * index
        sheet.box(14, y + 6, 452, 36, colour, colour + "14")
        sheet.text(28, y + 29, name, colour, weight="bold")
        sheet.text(108, y + 29, words, INK, size=15.5)
        if index + 1 < len(rows):
            sheet.arrow((240, y + 43), (240, y + 60), GREY)
    return sheet


DRAWINGS = {
    "camera-frame": camera_frame, "section": section, "in-the-image": in_the_image, "two-sources": two_sources,
    "end-states": end_states, "uncertainty": uncertainty, "stages": stages,
}  # fmt: skip

if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    for name, draw in DRAWINGS.items():
        draw().save(folder / f"{name}.svg")
