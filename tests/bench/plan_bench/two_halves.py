# SPDX-License-Identifier: Apache-2.0
"""Random buildings of two halves, each with a robot of its own, as campus files. Doors lead from one half to the other;
both robots stop before them and turn round, so that each is seen from both sides and nobody goes through."""
import random

APPROACH = 1.8  # m before a door, where a robot stops
RETREAT = 4.6
CLEAR = 1.3  # m between furniture and a robot's way


def distance(p, a, b):
    """Of a point from a segment."""
    length = abs(b - a) ** 2
    t = min(1.0, max(0.0, ((p - a) * (b - a).conjugate()).real / length)) if length else 0.0
    return abs(p - a - t * (b - a))


class Half:
    """Rooms above each other, from x to x + width."""

    def __init__(self, rng, name, x, width, height):
        count = rng.choice([2, 3])
        shares = [rng.uniform(0.8, 1.25) for _ in range(count)]
        self.name, self.x, self.width = name, x, width
        self.cuts = [0.0]
        for share in shares:
            self.cuts.append(round(self.cuts[-1] + height * share / sum(shares), 2))
        self.cuts[-1] = height
        self.inner = [round(rng.uniform(x + 1.5, x + width - 1.5), 2) for _ in range(count - 1)]

    def rooms(self):
        return list(zip(self.cuts, self.cuts[1:]))

    def route(self, doors, side):
        """From room to room, in each to its doors to the other half. side: 1 if these lie to the east, else -1."""
        wall = self.x + self.width if side > 0 else self.x
        steps, way = [], []

        def go(x, y):
            steps.append(f"[{x:.2f}, {y:.2f}]")
            way.append(complex(x, y))
        for i, (low, high) in enumerate(self.rooms()):
            middle = self.x + self.width / 2, (low + high) / 2
            go(*middle)
            for y in doors:
                if not low < y < high:
                    continue
                go(wall - side * RETREAT, y)
                go(wall - side * APPROACH, y)
                steps.append("{wait: 2}")
                steps.append(f"{{turn_to_deg: {180 if side > 0 else 0}}}")
                go(wall - side * RETREAT, y)
                go(*middle)
            if i < len(self.inner):
                go(self.inner[i], high - 1.5)
                steps.append(f"{{door: {self.name}{i}}}")
                way.append(complex(self.inner[i], high + 1.5))
        return steps, way

    def areas(self, doors, side):
        for i, (low, high) in enumerate(self.rooms()):
            cut = [f"{{id: {self.name}{i}, side: north, at: {self.inner[i] - self.x:.2f}, width: 1.0}}"] if i < len(self.inner) else []
            if side > 0:
                cut += [f"{{id: between{n}, side: east, at: {y - low:.2f}, width: 1.0}}" for n, y in enumerate(doors) if low < y < high]
            yield (f"  - {{id: {self.name}-{i}, rect: [{self.x:.2f}, {low:.2f}, {self.width:.2f}, {high - low:.2f}],"
                   f" doors: [{', '.join(cut)}]}}")


def furniture(rng, half, way):
    legs = list(zip(way, way[1:]))
    boxes = []
    for low, high in half.rooms():
        for _ in range(40):
            w, h = rng.uniform(0.5, 1.8), rng.uniform(0.4, 1.2)
            x, y = rng.uniform(half.x + 0.2, half.x + half.width - w - 0.2), rng.uniform(low + 0.2, high - h - 0.2)
            center = complex(x + w / 2, y + h / 2)
            if min(distance(center, a, b) for a, b in legs) > CLEAR + max(w, h) / 2 and rng.random() < 0.5:
                boxes.append(f"  - {{rect: [{x:.2f}, {y:.2f}, {w:.2f}, {h:.2f}], height: {rng.uniform(0.8, 2.0):.2f}}}")
                if len(boxes) % 4 == 0:
                    break
    return boxes


def campus(seed):
    """The text of a campus file, and the places of the doors between its halves, x and y, m."""
    rng = random.Random(seed)
    height = round(rng.uniform(13.0, 19.0), 2)
    wall = round(rng.uniform(7.0, 11.0), 2)
    west, east = Half(rng, "west", 0.0, wall, height), Half(rng, "east", wall, round(rng.uniform(7.0, 11.0), 2), height)
    cuts = sorted({*west.cuts, *east.cuts})
    doors = [round(rng.uniform(a + 1.4, b - 1.4), 2) for a, b in zip(cuts, cuts[1:]) if b - a >= 3.0]
    lines = [f"campus: two-halves-{seed}", f"texture_seed: {seed}", "areas:"]
    routes = []
    boxes = []
    for half, side in ((west, 1), (east, -1)):
        lines += half.areas(doors, side)
        steps, way = half.route(doors, side)
        routes.append(steps)
        boxes += furniture(rng, half, way)
    lines += ["boxes:", *boxes, "robots:"]
    for name, steps in zip(("west", "east"), routes):
        lines += [f"  - id: {name}", "    route:", *[f"      - {step}" for step in steps]]
    return "\n".join(lines) + "\n", [complex(wall, y) for y in doors]
