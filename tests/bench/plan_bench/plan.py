# SPDX-License-Identifier: Apache-2.0
"""What is true of a plan, and how far a placed plan is off."""
import json
import math
import statistics

from . import linear

CLASSES = ("seen", "near", "far")
SEEN = 0.3  # m: a place so near to a wall of the map was seen
STEP = 0.25  # m, between samples of walls
NEAR = 8.0  # m
RIGHT = 1.0  # m: a plan is placed right if the median wall that was seen lies no farther off


def median(values):
    return round(statistics.median(values), 4) if values else None


class Cells:
    """Points that are found by their place."""

    SIDE = 1.0  # m

    def __init__(self, points):
        self.points = {}
        for point in points:
            self.points.setdefault(self.key(point), []).append(point)

    def key(self, point):
        return math.floor(point.real / self.SIDE), math.floor(point.imag / self.SIDE)

    def distance(self, point, reach):
        """To the nearest, if that is within reach."""
        column, row = self.key(point)
        cells = math.ceil(reach / self.SIDE)
        return min((abs(point - other) for x in range(column - cells, column + cells + 1)
                    for y in range(row - cells, row + cells + 1) for other in self.points.get((x, y), ())), default=math.inf)

    def has(self, point, reach=SEEN):
        return self.distance(point, reach) < reach


class Plan:
    """A plan of a building; `to_map` puts places of the campus into the map's frame."""

    def __init__(self, folder, to_map):
        self.geojson = folder / "plan.geojson"
        self.picture = folder / "plan-filled.png"
        truth = json.loads((folder / "plan-truth.json").read_text())
        self.mirrored = truth["mirrored"]
        self.sheet = [complex(*corner["sheet_px"]) for corner in truth["corners"]]
        self.true = [to_map(complex(*corner["campus_m"])) for corner in truth["corners"]]
        self.all_walls = [(wall["from"], wall["to"]) for wall in truth["walls"]]
        self.invented = [wall["invented"] for wall in truth["walls"]]
        self.walls = [ends for ends, invented in zip(self.all_walls, self.invented) if not invented]
        self.left_out = [tuple(to_map(complex(*end)) for end in wall) for wall in truth["left_out"]]
        features = json.loads(self.geojson.read_text())["features"]
        self.door_sheet = [[complex(*point) for point in one["geometry"]["coordinates"]] for one in features
                           if one["properties"]["kind"] == "door"]
        self.room_sheet = {one["properties"]["name"]: [complex(*point) for point in one["geometry"]["coordinates"][0]]
                           for one in features if one["properties"]["kind"] == "room"}
        self.samples = [(wall, place) for wall, ends in enumerate(self.walls) for place in self.along(ends)]

    def along(self, ends, places=None):
        """Places on a wall, STEP apart."""
        places = places or self.true
        a, b = (places[end] for end in ends)
        count = max(1, round(abs(self.true[ends[1]] - self.true[ends[0]]) / STEP))
        return [a + (k + 0.5) / count * (b - a) for k in range(count)]

    def truth(self, model, corners=None):
        """The transform from the sheet to the map that puts these corners best where they are."""
        corners = range(len(self.sheet)) if corners is None else corners
        return linear.best([self.sheet[i] for i in corners], [self.true[i] for i in corners], model, self.mirrored)

    def across(self, places, sample):
        """How far the wall lies from where it is."""
        wall, true = sample
        a, b = (places[end] for end in self.walls[wall])
        return abs(((true - a) * (b - a).conjugate()).imag) / abs(b - a) if a != b else abs(true - a)


class Sight:
    """What of a plan a map has seen: samples of walls and corners, by how far from that they are."""

    def __init__(self, plan, walls):
        self.plan = plan
        self.walls = walls  # of the map, as Cells
        seen = Cells([place for _, place in plan.samples if walls.has(place)])
        self.seen = seen
        corners = sorted({end for wall in plan.walls for end in wall})
        self.samples_of = {name: [] for name in CLASSES}
        for sample in plan.samples:
            self.samples_of[self.of(sample[1])].append(sample)
        self.corners_of = {name: [] for name in CLASSES}
        for corner in corners:
            self.corners_of[self.of(plan.true[corner])].append(corner)

    def of(self, place):
        if self.walls.has(place):
            return "seen"
        return "near" if self.seen.distance(place, NEAR) <= NEAR else "far"

    def medians(self, places):
        plan = self.plan
        across = {name: sorted(plan.across(places, one) for one in of) for name, of in self.samples_of.items()}
        return {"walls": {name: median(values) for name, values in across.items()},
                "walls_p95": {name: round(values[int(0.95 * len(values))], 4) if values else None
                              for name, values in across.items()},
                "corners": {name: median([abs(places[i] - plan.true[i]) for i in of])
                            for name, of in self.corners_of.items()}}

    def judged(self, places):
        if places is None:
            return {}
        seen = median([self.plan.across(places, one) for one in self.samples_of["seen"]])
        return {"median_seen_m": seen, "right": seen <= RIGHT}
