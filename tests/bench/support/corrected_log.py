# SPDX-License-Identifier: Apache-2.0
"""CARMEN logs whose poses are a corrected path, and what benchmarks make of them: logs with worse odometry, and errors."""
import cmath
import gzip
import json
import math
import random
import subprocess

CLICK_SIGMA = 0.3  # m


def run(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout


def read(path):
    """Of each scan the ranges, m, and the corrected pose (x, y, yaw)."""
    scans = []
    for line in gzip.open(path, "rt"):
        words = line.split()
        if words and words[0] == "FLASER":
            count = int(words[1])
            values = [float(word) for word in words[2:5 + count]]
            scans.append((values[:count], tuple(values[count:])))
    return scans


def write_pairs(path, pairs):
    """As `prior fit --pairs` reads them: places on the plan and where they are, complex."""
    path.write_text("".join(f"{a.real},{a.imag},{b.real},{b.imag}\n" for a, b in pairs))


def turn(yaw):
    return cmath.rect(1, yaw)


def between(a, b):
    step = (complex(*b[:2]) - complex(*a[:2])) * turn(-a[2])
    return step.real, step.imag, math.remainder(b[2] - a[2], math.tau)


def compose(a, b):
    place = complex(*a[:2]) + complex(*b[:2]) * turn(a[2])
    return place.real, place.imag, a[2] + b[2]


def angles(count):
    """The first beam and the step, rad, as docs/logs.md says of FLASER."""
    return -math.pi / 2, math.pi / (count - 1 if count % 2 else count)


def write(scans, path, *, seed=0, noise=0.0, yaw_noise=0.0, nth=1, cut=None, odometry=True, no_return=math.inf):
    """A log in JSON lines, one scan a second. `noise`: of the odometry, m per m; `yaw_noise`: rad per m. `nth`: only each n-th scan; `cut`: m, of ranges. Returns the time and
    the corrected pose of each scan."""
    rng = random.Random(seed)
    pose, last, truth = (0.0, 0.0, 0.0), None, []
    with open(path, "w") as out:
        out.write('{"type":"log","version":1}\n')
        for number, (ranges, corrected) in enumerate(scans[::nth]):
            time = (number + 1) * 10**9
            if last is not None:
                x, y, yaw = between(last, corrected)
                length = math.hypot(x, y)
                pose = compose(pose, (x + rng.gauss(0, noise * length), y + rng.gauss(0, noise * length),
                                      yaw + rng.gauss(0, yaw_noise * length)))
            last = corrected
            if odometry:
                out.write(json.dumps({"type": "odometry", "time_ns": time,
                                      "pose": {"x_m": pose[0], "y_m": pose[1], "yaw_rad": pose[2]}}) + "\n")
            most = min(cut or math.inf, no_return, 80.0)
            first, step = angles(len(ranges))
            out.write(json.dumps({"type": "scan", "time_ns": time, "angle_min_rad": first, "angle_increment_rad": step,
                                  "range_min_m": 0.02, "range_max_m": most,
                                  "ranges_m": ["inf" if value >= most else value for value in ranges]}) + "\n")
            truth.append((time, corrected))
    return truth


def worsen(source, target, *, bias, seed):
    """A log in JSON lines with worse odometry: each step is off by the share `bias` of its length in x and in y, and of its
    turn, each with a sign that is drawn, and the errors add up."""
    rng = random.Random(seed)
    last, pose = None, None
    with open(source) as lines, open(target, "w") as out:
        for line in lines:
            record = json.loads(line)
            if record["type"] != "odometry":
                out.write(line)
                continue
            given = tuple(record["pose"][key] for key in ("x_m", "y_m", "yaw_rad"))
            if last is None:
                pose = given
            else:
                x, y, yaw = between(last, given)
                length = math.hypot(x, y)
                signs = [rng.choice((-1, 1)) for _ in range(3)]
                pose = compose(pose, (x + signs[0] * bias * length, y + signs[1] * bias * length, yaw * (1 + signs[2] * bias)))
            last = given
            record["pose"] = dict(zip(("x_m", "y_m", "yaw_rad"), pose))
            out.write(json.dumps(record) + "\n")


def errors(trajectory, truth):
    """After the turn and shift that fit best: the root of the mean squared distance and the largest one, m, and the same of
    yaws, deg. `trajectory`: the file that `enfilade slam` writes."""
    known = {time: (complex(*pose[:2]), pose[2]) for time, pose in truth}
    pairs = []
    for line in open(trajectory):
        seconds, x, y, yaw = line.split()
        time = int(seconds.replace(".", ""))
        if time in known:
            pairs.append((complex(float(x), float(y)), float(yaw), *known[time]))
    count = len(pairs)
    mean = sum(p[0] for p in pairs) / count
    true_mean = sum(p[2] for p in pairs) / count
    rotation = sum((p[2] - true_mean) * (p[0] - mean).conjugate() for p in pairs)
    rotation /= abs(rotation)
    off = [abs((p[0] - mean) * rotation + true_mean - p[2]) for p in pairs]
    turned = [math.degrees(math.remainder(p[1] + cmath.phase(rotation) - p[3], math.tau)) for p in pairs]
    return {"ate_m": round(math.sqrt(sum(value * value for value in off) / count), 4), "max_m": round(max(off), 3),
            "yaw_deg": round(math.sqrt(sum(value * value for value in turned) / count), 3), "scans": count}


class Points:
    """Points that are found by their place."""

    SIDE = 1.0  # m

    def __init__(self, points):
        self.cells = {}
        for point in points:
            self.cells.setdefault(self._cell(point), []).append(point)

    def _cell(self, point):
        return math.floor(point.real / self.SIDE), math.floor(point.imag / self.SIDE)

    def distance(self, point, reach):
        """To the nearest, m; infinite beyond reach."""
        column, row = self._cell(point)
        cells = math.ceil(reach / self.SIDE)
        least = min((abs(point - other) for x in range(column - cells, column + cells + 1)
                     for y in range(row - cells, row + cells + 1) for other in self.cells.get((x, y), ())), default=math.inf)
        return least if least <= reach else math.inf


def door_pairs(path):
    """Pairs of a plan's pixels and places in the frame of the corrected path, by the doors of a laser_doors file."""
    known = json.load(open(path))
    pairs = []
    for door in known["doors"]:
        place = complex(door["x_m"], door["y_m"])
        turned = place * turn(known["theta"])
        pairs.append((complex((turned.real - known["mn"][0]) / known["res"] + known["offset_px"][0],
                              (-turned.imag - known["mn"][1]) / known["res"] + known["offset_px"][1]), place))
    return pairs


def far_apart(pairs, count):
    """The pair that is farthest out, then each time the one that is farthest from those chosen."""
    middle = sum(pixel for pixel, _ in pairs) / len(pairs)
    chosen = [max(pairs, key=lambda pair: abs(pair[0] - middle))]
    while len(chosen) < min(count, len(pairs)):
        chosen.append(max(pairs, key=lambda pair: min(abs(pair[0] - other[0]) for other in chosen)))
    return chosen


def clicks(known, apart, rng):
    """Two of `known` (pixel, place)."""
    a, b = rng.choice([(a, b) for a in known for b in known if abs(a[1] - b[1]) >= apart])
    return [(pixel, place + complex(rng.gauss(0, CLICK_SIGMA), rng.gauss(0, CLICK_SIGMA))) for pixel, place in (a, b)]


def corners_of(tool, plan, folder):
    """Pixels."""
    run(tool, "prior", "import", plan, "-o", folder / "plan.geojson")
    return [complex(*one["geometry"]["coordinates"]) for one in json.loads((folder / "plan.geojson").read_text())["features"]
            if one["properties"]["kind"] == "corner"]


def seen_corners(tool, source, plan, folder):
    """The plan's corners that a log or map shows, and where they are in its frame."""
    points = folder / "corners.csv"
    points.write_text("".join(f"{p.real},{p.imag}\n" for p in corners_of(tool, plan, folder)))
    run(tool, "prior", "fit", plan, source, "-o", folder / "fit-corners", "--points", points)
    rows = [line.split(",") for line in (folder / "fit-corners" / "points.csv").read_text().splitlines()[1:]]
    return [(complex(float(r[0]), float(r[1])), complex(float(r[2]), float(r[3]))) for r in rows
            if r[5] == "seen" and float(r[4]) < 0.1]
