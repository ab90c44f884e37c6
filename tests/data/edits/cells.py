# SPDX-License-Identifier: Apache-2.0
"""Which cells an edit covers, by the definitions in map_edit.proto, one cell at a time.

Slow and simple on purpose: it shares no code and no method with the programs that are tested with its results.
"""
UNITS = 256
TILE = 256
VALUES = {"VALUE_UNKNOWN": 1, "VALUE_FREE": 2, "VALUE_OCCUPIED": 3, "VALUE_CLEAR": 0}


def centre(cell):
    return cell * UNITS + UNITS // 2


def cells_around(points, margin):
    """All cells of the points' box, one more on each side."""
    columns = [p["x"] // UNITS for p in points]
    rows = [p["y"] // UNITS for p in points]
    more = margin // UNITS + 2
    for row in range(min(rows) - more, max(rows) + more + 1):
        for column in range(min(columns) - more, max(columns) + more + 1):
            yield column, row


def is_near(x, y, a, b, radius):
    """Whether (x, y) is at most `radius` away from the segment from a to b."""
    dx, dy = b["x"] - a["x"], b["y"] - a["y"]
    px, py = x - a["x"], y - a["y"]
    along, length2 = px * dx + py * dy, dx * dx + dy * dy
    if along <= 0:
        return px * px + py * py <= radius * radius
    if along >= length2:
        return (x - b["x"]) ** 2 + (y - b["y"]) ** 2 <= radius * radius
    return (px * dy - py * dx) ** 2 <= radius * radius * length2


def brush(shape):
    points, radius = shape["points"], shape["radius"]
    segments = list(zip(points, points[1:])) or [(points[0], points[0])]
    for a, b in segments:
        for column, row in cells_around([a, b], radius):
            if is_near(centre(column), centre(row), a, b, radius):
                yield column, row


def line(shape):
    """The cell nearest to the line from centre to centre at each step along the longer axis; of two, the greater."""
    cells = [(p["x"] // UNITS, p["y"] // UNITS) for p in shape["points"]]
    yield cells[0]
    for (x0, y0), (x1, y1) in zip(cells, cells[1:]):
        steps = max(abs(x1 - x0), abs(y1 - y0))
        for i in range(steps + 1):
            if abs(x1 - x0) >= abs(y1 - y0):
                yield x0 + (i if x1 >= x0 else -i), y0 + (2 * i * (y1 - y0) + steps) // (2 * steps or 1)
            else:
                yield x0 + (2 * i * (x1 - x0) + steps) // (2 * steps), y0 + (i if y1 >= y0 else -i)


def polygon(shape):
    sides = [(ring["points"][i - 1], ring["points"][i]) for ring in shape["rings"] for i in range(len(ring["points"]))]
    for column, row in cells_around([a for a, _ in sides], 0):
        x, y = centre(column), centre(row)
        inside = False
        for a, b in sides:
            turn = (b["x"] - a["x"]) * (y - a["y"]) - (b["y"] - a["y"]) * (x - a["x"])
            if (turn == 0 and min(a["x"], b["x"]) <= x <= max(a["x"], b["x"]) and
                    min(a["y"], b["y"]) <= y <= max(a["y"], b["y"])):
                inside = True
                break
            if (a["y"] <= y) != (b["y"] <= y) and (turn > 0) == (b["y"] > a["y"]):
                inside = not inside
        if inside:
            yield column, row


def patch(shape):
    box, at, takes = shape["box"], 0, False
    for run in shape["runs"]:
        if takes:
            for i in range(at, at + run):
                yield box["firstColumn"] + i % box["width"], box["firstRow"] + i // box["width"]
        at, takes = at + run, not takes


SHAPES = {"brush": brush, "line": line, "polygon": polygon, "patch": patch}


def covered(edit):
    kind = next(name for name in SHAPES if name in edit)
    return set(SHAPES[kind](edit[kind]))


def draw(edits):
    """The cells with a value after all edits, later ones over earlier ones."""
    cells = {}
    for edit in edits:
        cells.update(dict.fromkeys(covered(edit), VALUES[edit["value"]]))
    return {cell: value for cell, value in cells.items() if value != 0}


def tiles(cells):
    """{(row, column): bytes} of the tiles that have a value."""
    made = {}
    for (column, row), value in cells.items():
        tile = made.setdefault((row // TILE, column // TILE), bytearray(TILE * TILE))
        tile[row % TILE * TILE + column % TILE] = value
    return made
