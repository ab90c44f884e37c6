# SPDX-License-Identifier: Apache-2.0
"""Ways through the planning map to rooms that the robot has not seen, and the same ways in the building as it is: its exact
walls, with all doors open, and whatever the robot has seen there. A way keeps RADIUS away from walls. Also: is the map what
Nav2's map_server loads, are the cells that the robot has seen untouched, and does the mask say the truth?"""
import heapq

from .files import Raster, read_png

RADIUS = 0.2  # m
STRIDE = 2  # cells, between the nodes of ways
KNOWN = 0.1  # share of an unseen room that the robot may have seen
UNKNOWN = 205  # grey


def measure(building):
    _, _, folder = building.fitted()
    planning = Raster(folder / "planning.yaml")
    found = untouched(building.raster, planning, folder / "planning-mask.png")
    true = true_map(building, planning)
    start = planning.index(0j)  # where the robot was switched on
    goals = {name: goal for name, goal in goals_in(building, planning, true).items() if goal is not None}
    ways = [distances(planning, cells, start, goals.values()) for cells in (planning.cells, true)]
    found["goals"] = [{"room": name, "planned_m": ways[0].get(goal), "true_m": ways[1].get(goal)}
                      for name, goal in goals.items()]
    return found


def untouched(seen, planning, mask):
    shift = (seen.origin - planning.origin) / planning.resolution
    column, row = round(shift.real), round(shift.imag)
    width, height, channels, rows = read_png(mask)
    if (width, height, channels) != (planning.width, planning.height, 1):
        raise ValueError(f"{mask}: {width} x {height}, {channels} channels")
    sources = b"".join(reversed(rows))
    changed = 0
    expected = bytearray(2 if value != UNKNOWN else 0 for value in planning.grey)
    for y in range(seen.height):
        at = (y + row) * planning.width + column
        for x in range(seen.width):
            value = seen.grey[y * seen.width + x]
            if value == UNKNOWN:
                continue
            changed += planning.grey[at + x] != value
            expected[at + x] = 1
    return {"cells": len(sources), "on_lattice": abs(shift - complex(column, row)) < 1e-6, "changed": changed,
            "wrong_mask": sum(a != b for a, b in zip(sources, expected))}


def inside(raster, outline):
    """The cells of a polygon, row by row."""
    to = [(point - raster.origin) / raster.resolution for point in outline]
    low, high = min(p.imag for p in to), max(p.imag for p in to)
    for row in range(max(0, int(low)), min(raster.height, int(high) + 1)):
        y = row + 0.5
        crossings = sorted(a.real + (y - a.imag) / (b.imag - a.imag) * (b.real - a.real)
                           for a, b in zip(to, to[1:] + to[:1]) if (a.imag <= y) != (b.imag <= y))
        for left, right in zip(crossings[::2], crossings[1::2]):
            for column in range(max(0, round(left)), min(raster.width, round(right))):
                yield row * raster.width + column


def strip(raster, a, b, half):
    """The cells up to `half` away from a line."""
    side = half * 1j * (b - a) / abs(b - a)
    return inside(raster, [a + side, b + side, b - side, a - side])


def true_map(building, lattice):
    """0 free, 1 occupied, 2 unknown."""
    exact = building.exact()
    transform = exact.truth("similarity")
    cells = bytearray(b"\2" * len(lattice.cells))
    for room in exact.room_sheet.values():
        for cell in inside(lattice, [transform(point) for point in room]):
            cells[cell] = 0
    seen = building.raster
    for index, kind in enumerate(seen.cells):
        if kind != 2:
            cells[lattice.index(seen.place(index))] = kind
    for ends in exact.walls:
        a, b = (exact.true[end] for end in ends)
        if a != b:
            for cell in strip(lattice, a, b, 0.075):
                cells[cell] = 1
    for door in exact.door_sheet:
        a, b = (transform(end) for end in door)
        for cell in strip(lattice, a, b, 0.2):
            if cells[cell] == 2:
                cells[cell] = 0
    return bytes(cells)


def blocked(raster, cells):
    """Cells that are not free, or nearer to such than the robot is wide."""
    reach = round(RADIUS / raster.resolution)
    widths = [int((reach * reach - dy * dy) ** 0.5) for dy in range(reach + 1)]
    result = bytearray(0 if cell == 0 else 1 for cell in cells)
    width = raster.width
    for index, cell in enumerate(cells):
        if cell != 1:
            continue
        column = index % width
        for dy in range(-reach, reach + 1):
            row = index // width + dy
            if not 0 <= row < raster.height:
                continue
            left, right = max(0, column - widths[abs(dy)]), min(width, column + widths[abs(dy)] + 1)
            result[row * width + left : row * width + right] = b"\1" * (right - left)
    return result


def node(raster, index):
    """The nearest node of ways."""
    column, row = index % raster.width, index // raster.width
    return column - column % STRIDE, row - row % STRIDE


def distances(raster, cells, start, goals):
    """From the start to each goal that can be reached, m."""
    walls = blocked(raster, cells)
    width, side = raster.width, STRIDE * raster.resolution
    steps = [(dx, dy, side * (dx * dx + dy * dy) ** 0.5 / STRIDE) for dx in (-STRIDE, 0, STRIDE)
             for dy in (-STRIDE, 0, STRIDE) if dx or dy]
    wanted = {node(raster, goal): goal for goal in goals}
    begin = node(raster, start)
    known, found = {begin: 0.0}, {}
    queue = [(0.0, begin)]
    while queue and len(found) < len(wanted):
        far, at = heapq.heappop(queue)
        if far > known[at]:
            continue
        if at in wanted:
            found[wanted[at]] = round(far, 2)
        for dx, dy, step in steps:
            x, y = at[0] + dx, at[1] + dy
            if 0 <= x < width and 0 <= y < raster.height and not walls[y * width + x] and \
               far + step < known.get((x, y), 1e9):
                known[x, y] = far + step
                heapq.heappush(queue, (far + step, (x, y)))
    return found


def goals_in(building, raster, true):
    """Of each room that the robot has not seen, the free place that is farthest from its walls."""
    exact = building.exact()
    transform = exact.truth("similarity")
    goals = {}
    for name, outline in exact.room_sheet.items():
        cells = list(inside(raster, [transform(point) for point in outline]))
        seen = [building.raster.index(raster.place(cell)) for cell in cells]
        known = sum(cell is not None and building.raster.cells[cell] != 2 for cell in seen)
        if not cells or known > KNOWN * len(cells):
            continue
        goals[name] = deepest(raster, set(cells), true)
    return goals


def deepest(raster, cells, true):
    """By peeling layer after layer."""
    layer = {cell for cell in cells if true[cell] == 0}
    last = None
    while layer:
        last = min(layer)
        layer = {cell for cell in layer if {cell - 1, cell + 1, cell - raster.width, cell + raster.width} <= layer}
    return last
