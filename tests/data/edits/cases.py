# SPDX-License-Identifier: Apache-2.0
"""The edits of each file."""
import math
import random

import cells

UNKNOWN, FREE, OCCUPIED, CLEAR = "VALUE_UNKNOWN", "VALUE_FREE", "VALUE_OCCUPIED", "VALUE_CLEAR"
LIMIT = 1 << 29  # of coordinates
SIDE = 1 << 22  # of a segment, along each axis
RADIUS = 1 << 16  # of a brush
CELL = 256


def points(*pairs):
    return [{"x": x, "y": y} for x, y in pairs]


def at(*cells):
    """The centres of cells."""
    return points(*((column * CELL + 128, row * CELL + 128) for column, row in cells))


def brush(value, path, radius):
    return {"value": value, "brush": {"points": path, "radius": radius}}


def line(value, path):
    return {"value": value, "line": {"points": path}}


def polygon(value, *rings):
    return {"value": value, "polygon": {"rings": [{"points": ring} for ring in rings]}}


def rectangle(value, left, bottom, right, top):
    return polygon(value, points((left, bottom), (right, bottom), (right, top), (left, top)))


def patch(value, column, row, width, height, runs):
    box = {"firstColumn": column, "firstRow": row, "width": width, "height": height}
    return {"value": value, "patch": {"box": box, "runs": runs}}


def brushes():
    return [
        brush(OCCUPIED, at((10, 10)), 5 * CELL),
        brush(FREE, at((40, 10), (90, 30), (60, 60)), 3 * CELL),
        brush(UNKNOWN, points((5000, 20000), (5001, 20003), (9000, 21007), (30011, 20999)), 641),
        brush(OCCUPIED, points((30000, 4000), (30000, 4000)), 700),  # twice the same point
        brush(FREE, at((120, 20), (120, 90)), 128),  # centres beside it are exactly on the edge of the next cell
        brush(OCCUPIED, at((140, 20), (180, 20)), CELL),  # centres are exactly on its edge
        brush(UNKNOWN, at((200, 20)), 5 * 51 + 1),
        brush(OCCUPIED, at((200, 40)), 1280),  # (3, 4, 5): centres are exactly on the circle
    ]


def thin_brushes():
    return [
        brush(OCCUPIED, at((3, 3)), 0),
        brush(FREE, at((10, 10), (30, 10)), 0),
        brush(FREE, at((10, 12), (10, 40)), 0),
        brush(UNKNOWN, at((12, 12), (40, 40)), 0),
        brush(OCCUPIED, at((50, 10), (90, 30)), 0),  # every second row
        brush(FREE, points((50 * CELL, 40 * CELL + 1), (90 * CELL, 60 * CELL + 77)), 20),
        brush(UNKNOWN, points((50 * CELL + 3, 70 * CELL + 1), (57 * CELL, 120 * CELL + 77)), 100),
        brush(OCCUPIED, points((70 * CELL, 70 * CELL), (73 * CELL + 11, 130 * CELL)), 181),
        brush(FREE, points((-3000, -9000), (4000, -2001)), 90),
    ]


def lines():
    star = [line((UNKNOWN, FREE, OCCUPIED)[i % 3], at((0, 0), (round(60 * math.cos(i)), round(60 * math.sin(i)))))
            for i in range(24)]
    ties = [line(OCCUPIED, at((100, 0), (104, 2))), line(FREE, at((104, 12), (100, 10))),
            line(OCCUPIED, at((100, 30), (96, 28))), line(FREE, at((120, 0), (122, 8))),
            line(OCCUPIED, at((130, 8), (128, 0))), line(UNKNOWN, at((140, 10), (151, 10), (151, 30), (140, 41)))]
    backwards = line(FREE, points((-1, -1), (-256, -256), (-257, 0), (255, 1)))
    return star + ties + [line(OCCUPIED, at((-200, 77))), backwards]


def polygons():
    rhombus = points((2560, 0), (5120, 2560), (2560, 5120), (0, 2560))
    hourglass = points((30000, 0), (40000, 0), (35000, 5000), (40000, 10000), (30000, 10000), (35000, 5000))
    comb = points((0, 12000), *((x * 300, 12000 + (9000 if x % 2 else 800)) for x in range(1, 60)), (18000, 12000))
    star = points(*((round(24000 + (6000, 2500)[i % 2] * math.cos(i * math.pi / 7)),
                     round(16000 + (6000, 2500)[i % 2] * math.sin(i * math.pi / 7))) for i in range(14)))
    return [
        polygon(OCCUPIED, rhombus),
        polygon(FREE, at((30, 0), (50, 0), (50, 20), (40, 8), (30, 20))),  # all corners are centres
        polygon(UNKNOWN, hourglass),
        polygon(OCCUPIED, comb),
        polygon(FREE, star),
        polygon(UNKNOWN, points((60000, 100), (60100, 40000), (60240, 100))),  # narrower than a cell
        polygon(OCCUPIED, at((240, 20), (240, 20), (250, 30), (245, 30), (240, 30))),  # a corner twice, one on a side
        polygon(FREE, at((5, 100), (25, 100), (15, 100))),  # without area: its sides
        polygon(UNKNOWN, points((-500, -500), (-20000, -700), (-18000, -9000), (-9000, -4000), (-300, -15000))),
    ]


def polygons_with_holes():
    return [
        polygon(OCCUPIED, at((0, 0), (60, 0), (60, 60), (0, 60)), at((10, 10), (10, 50), (50, 50), (50, 10)),
                at((20, 20), (40, 20), (40, 40), (20, 40))),  # an island in a hole
        polygon(FREE, at((70, 0), (100, 0), (100, 30), (70, 30)), at((85, 15), (115, 15), (115, 45), (85, 45))),
        polygon(UNKNOWN, at((0, 80), (30, 80), (15, 110)), at((0, 80), (30, 80), (15, 110))),  # only its edge is left
        polygon(OCCUPIED, points((40000, 0), (60000, 0), (50000, 20000)),
                points((45000, 1000), (55000, 1000), (50000, 9000)),
                points((50000, 11000), (50100, 15000), (49900, 15000))),
        polygon(FREE, points((-40000, -40000), (-100, -39000), (-500, -300)),
                points((-30000, -38000), (-3000, -37000), (-3500, -9000))),
    ]


def rectangles():
    return [
        rectangle(OCCUPIED, 0, 0, 10 * CELL, 5 * CELL),
        rectangle(FREE, 20 * CELL + 128, 128, 30 * CELL + 128, 5 * CELL + 128),  # from centre to centre
        rectangle(UNKNOWN, 40 * CELL + 129, 129, 50 * CELL + 127, 5 * CELL + 127),  # just inside of them
        rectangle(OCCUPIED, 60 * CELL + 128, 10 * CELL, 60 * CELL + 128, 20 * CELL),  # without width
        rectangle(FREE, -300 * CELL, 40 * CELL, 300 * CELL, 44 * CELL),
        rectangle(CLEAR, -10 * CELL, 41 * CELL, 10 * CELL, 43 * CELL),
        polygon(UNKNOWN, points((20000, 20000), (40000, 26000), (37000, 36000), (17000, 30000))),  # turned
    ]


def patches():
    return [
        patch(OCCUPIED, 0, 0, 10, 10, [0, 100]),
        patch(FREE, 20, 0, 10, 10, [5, 3, 17, 40, 1]),
        patch(UNKNOWN, 40, 0, 3, 50, [1] * 150),
        patch(OCCUPIED, 60, 0, 7, 7, [0, 0, 3, 4, 0, 9]),  # runs of no cells
        patch(FREE, 250, 250, 12, 12, [0, 144]),
        patch(CLEAR, 254, 254, 4, 4, [0, 2, 2, 2, 2, 2, 2, 2]),
        patch(UNKNOWN, -260, -3, 520, 6, [500, 100, 300, 40, 60, 1800]),
        patch(OCCUPIED, 1000, -1000, 4000, 4000, [7_999_999, 2, 4_000_000, 3]),  # far apart
    ]


def tile_edges():
    edits = []
    for column in (-512, -256, 0, 256):
        for row in (-512, -256, 0, 256):
            edits.append(brush(OCCUPIED, points((column * CELL, row * CELL)), 3 * CELL))
            edits.append(line(FREE, at((column - 1, row - 1), (column, row))))
            edits.append(patch(UNKNOWN, column - 1, row + 4, 2, 1, [0, 2]))
    return edits + [rectangle(CLEAR, -CELL, -CELL, CELL, CELL),
                    line(OCCUPIED, at((-257, 300), (256, 300), (256, -257)))]


def overlaps():
    """Later ones lie over earlier ones, and `clear` takes away."""
    edits = []
    for i in range(12):
        value = (OCCUPIED, FREE, UNKNOWN, CLEAR)[i % 4]
        edits.append(brush(value, at((20 + 9 * i, 30), (60 + 5 * i, 90 - 4 * i)), (12 - i) * CELL))
    return edits + [rectangle(CLEAR, 70 * CELL, 0, 80 * CELL, 120 * CELL), line(OCCUPIED, at((60, 50), (140, 55)))]


def cleared():
    """Nothing is left."""
    return [brush(OCCUPIED, at((0, 0), (40, 40)), 700), rectangle(FREE, 0, 0, 9000, 9000),
            patch(UNKNOWN, -5, -5, 5, 5, [0, 25]), brush(CLEAR, at((20, 20)), 80 * CELL)]


def extremes():
    """At the limits of coordinates, sides and radii."""
    far = LIMIT - 5000
    return [
        brush(OCCUPIED, points((0, 0)), RADIUS),
        brush(FREE, points((LIMIT, LIMIT)), 1000),
        brush(UNKNOWN, points((-LIMIT, -LIMIT), (-far, -far)), 300),
        brush(FREE, points((100_000, 200_000), (100_000 + SIDE, 201_234)), 400),
        line(OCCUPIED, points((-LIMIT, 0), (-LIMIT + SIDE, SIDE))),
        line(FREE, points((0, -LIMIT), (SIDE, -LIMIT + 9999), (9999, -LIMIT + 10_001))),
        polygon(UNKNOWN, points((-SIDE // 2, -300_000), (SIDE // 2, -299_000), (SIDE // 2, -297_000))),
        polygon(OCCUPIED, points((LIMIT, -LIMIT), (LIMIT - 6000, -LIMIT), (LIMIT, -LIMIT + 6000))),
        patch(FREE, LIMIT // CELL, 0, 3, 3, [0, 9]),
        patch(OCCUPIED, -LIMIT // CELL, LIMIT // CELL, 2, 2, [1, 2]),
    ]


def stroke():
    """One stroke as a hand draws it."""
    path = points(*((round(12_000 + 9000 * math.cos(i / 21) + 40 * i), round(15_000 + 11_000 * math.sin(i / 17)))
                    for i in range(400)))
    return [brush(OCCUPIED, path, 333), brush(FREE, path[100:300], 120)]


def random_ring(rng, x, y, size):
    """Corners by their angle, all around a point: sides do not cross."""
    count = rng.randint(3, 9)
    angles = [2 * math.pi * (i + 0.9 * rng.random()) / count for i in range(count)]
    corners = []
    for angle in angles:
        radius = rng.uniform(0.2, 1) * size
        corners.append((x + round(radius * math.cos(angle)), y + round(radius * math.sin(angle))))
    return points(*corners)


def any_edit(rng):
    value = rng.choice((OCCUPIED, FREE, UNKNOWN, CLEAR))
    x, y = rng.randint(-80_000, 80_000), rng.randint(-80_000, 80_000)
    near = [(x + rng.randint(-4000, 4000), y + rng.randint(-4000, 4000)) for _ in range(rng.randint(1, 6))]
    kind = rng.randrange(5)
    if kind == 0:
        return brush(value, points(*near), rng.choice((0, 1, 100, 128, 256, rng.randint(0, 3000))))
    if kind == 1:
        return line(value, points(*near))
    if kind == 2:
        return polygon(value, *(random_ring(rng, x, y, size) for size in (6000, 2500)[:rng.randint(1, 2)]))
    if kind == 3:
        return rectangle(value, x, y, x + rng.randint(0, 9000), y + rng.randint(0, 9000))
    width, height = rng.randint(1, 40), rng.randint(1, 40)
    runs, left = [], width * height
    while left > 0:
        runs.append(rng.randint(0, min(left, 30)))
        left -= runs[-1]
    return patch(value, x // CELL, y // CELL, width, height, runs)


def randoms():
    """Those that cover a cell: others are refused."""
    rng = random.Random(22)
    edits = (any_edit(rng) for _ in range(420))
    return [edit for edit in edits if cells.covered(edit)]


CASES = {"brush": brushes, "thin_brush": thin_brushes, "line": lines, "polygon": polygons,
         "polygon_with_holes": polygons_with_holes, "rectangle": rectangles, "patch": patches, "tile_edges": tile_edges,
         "overlaps": overlaps, "cleared": cleared, "extremes": extremes, "stroke": stroke, "random": randoms}
