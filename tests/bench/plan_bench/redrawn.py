# SPDX-License-Identifier: Apache-2.0
"""A plan of a real building that the simulator draws anew, as people do: its walls become a campus, of which
`enfilade simulate --plan-out --plan-deform SEED` writes a plan. Nobody needs to drive there."""
import json

from .files import run
from .plan import Cells

REACH = 3.0  # m, of distances to walls
SPACING = 0.1  # m, between points on walls


class Redrawn:
    def __init__(self, tool, plan, metres_per_px, folder):
        self.tool, self.metres, self.folder = tool, metres_per_px, folder
        folder.mkdir(parents=True, exist_ok=True)
        run(tool, "prior", "import", plan, "-o", folder / "read.geojson")
        features = json.loads((folder / "read.geojson").read_text())["features"]
        self.campus = folder / "campus.yaml"
        self.campus.write_text(self.of(features))

    def of(self, features):
        """The text of a campus file."""
        def at(point):
            return [round(point[0] * self.metres, 4), round(-point[1] * self.metres, 4)]

        def ends(kind):
            return [[at(point) for point in one["geometry"]["coordinates"]] for one in features
                    if one["properties"]["kind"] == kind]
        points = [point for wall in ends("wall") for point in wall]
        low, high = [[end(point[axis] for point in points) for axis in (0, 1)] for end in (min, max)]
        around = [low[0] - 4, low[1] - 4, high[0] - low[0] + 8, high[1] - low[1] + 8]
        thicknesses = [one["properties"].get("thickness", 0) * self.metres or 0.1 for one in features
                       if one["properties"]["kind"] == "wall"]
        lines = ["campus: redrawn", "areas:", f"  - {{id: ground, kind: outdoor, rect: {around}}}", "walls:"]
        lines += [f"  - {{points: {wall}, thickness: {round(thickness, 3)}}}" for wall, thickness in zip(ends("wall"), thicknesses)]
        doors = ends("door")
        if doors:
            lines += ["doors:", *[f"  - {{id: d{i}, from: {a}, to: {b}}}" for i, (a, b) in enumerate(doors)]]
        x, y = low[0] - 2, low[1] - 2  # outside
        return "\n".join(lines + ["robots:", "  - id: nobody", f"    route: [[{x}, {y}], [{x + 1}, {y}]]", ""])

    def drawn(self, *errors):
        """`errors`: options of `simulate`; without them as it was read."""
        out = self.folder / "-".join(["plan", *(str(word).lstrip("-") for word in errors)])
        run(self.tool, "simulate", self.campus, "-o", out / "drive", "--plan-out", out, "--beams", 8, "--scan-hz", 0.1, *errors)
        return Drawing(out, self.metres)


class Drawing:
    """Places are pixels of the plan that was drawn anew."""

    def __init__(self, folder, metres):
        def pixel(point):
            return complex(point[0], -point[1]) / metres
        truth = json.loads((folder / "plan-truth.json").read_text())
        self.plan = folder / "plan.geojson"
        self.sheet = [complex(*corner["sheet_px"]) for corner in truth["corners"]]
        self.corners = [pixel(corner["campus_m"]) for corner in truth["corners"]]
        self.walls = [(self.corners[wall["from"]], self.corners[wall["to"]]) for wall in truth["walls"] if not wall["invented"]]
        self.real = sorted({end for wall in truth["walls"] if not wall["invented"] for end in (wall["from"], wall["to"])})
        self.left_out = [tuple(pixel(end) for end in wall) for wall in truth["left_out"]]

    def carried(self, pairs, to_world):
        """Pairs of pixels and places onto this sheet: each to the next corner of a wall."""
        result = []
        for pixel, place in pairs:
            nearest = min(self.real, key=lambda i: abs(self.corners[i] - pixel))
            result.append((self.sheet[nearest], place + to_world(self.corners[nearest]) - to_world(pixel)))
        return result

    def has(self, to_world):
        """Whether of all walls the one nearest to a place of the world is drawn."""
        def points(walls):
            found = []
            for a, b in (tuple(map(to_world, wall)) for wall in walls):
                steps = max(1, round(abs(b - a) / SPACING))
                found += [a + (b - a) * k / steps for k in range(steps + 1)]
            return Cells(found)
        drawn, left_out = points(self.walls), points(self.left_out)
        return lambda place: drawn.distance(place, REACH) <= left_out.distance(place, REACH)
