# SPDX-License-Identifier: Apache-2.0
"""Maps in a chain, of a robot whose odometry is bad: how far are its poses off, with and without the plan? The odometry is
disturbed as the Auto-Complete Graph's authors do, but before anything is computed, and errors add up: of each 0.5 m, both
x and y are off by +-p of the way, and the turn is longer or shorter by p. The drive is cut into parts. Each is mapped by
itself, without closing loops with the others, and begins where the one before ends: that is the chain without a plan. With
it, `enfilade prior fit` joins the maps; one that it leaves out stays where the chain has it, behind the one before."""
import cmath
import json
import math
import random

from .building import BASELINE
from .files import Raster, read_poses, run
from .plan import Cells, Sight

STRIDE = 0.5  # m
TURNS = 0.5  # rad: a stretch ends there, too


def wrapped(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


def times(a, b):
    """Of poses: place and yaw."""
    return a[0] + b[0] * cmath.rect(1, a[1]), wrapped(a[1] + b[1])


def between(a, b):
    return (b[0] - a[0]) * cmath.rect(1, -a[1]), wrapped(b[1] - a[1])


def disturbed(log, share, rng, to):
    """The same log with other odometry."""
    lines, last, noisy, left = [], None, None, 0.0
    factors = (0.0, 0.0, 1.0)
    for line in log.read_text().splitlines():
        record = json.loads(line) if line.startswith('{"type":"odometry"') else None
        if record:
            pose = complex(record["pose"]["x_m"], record["pose"]["y_m"]), record["pose"]["yaw_rad"]
            if last is None:
                noisy = pose
            else:
                step = between(last, pose)
                if left <= 0:
                    left = STRIDE
                    factors = tuple(rng.choice((-share, share)) for _ in range(3))
                left -= max(abs(step[0]), abs(step[1]) * STRIDE / TURNS)
                off = abs(step[0]) * complex(factors[0], factors[1])
                noisy = times(noisy, (step[0] + off, step[1] * (1 + factors[2])))
            last = pose
            record["pose"] = {"x_m": noisy[0].real, "y_m": noisy[0].imag, "yaw_rad": noisy[1]}
            line = json.dumps(record)
        lines.append(line + "\n")
    to.write_text("".join(lines))
    return to


def measure(building, shares, parts):
    return {f"{share:.1f}": at(building, share, parts) for share in shares}


def cut(log, share, parts, folder):
    """The logs of parts of the drive, each of which ends with the scan with which the next one begins."""
    lines = log.read_text().splitlines(keepends=True)
    scans = [i for i, line in enumerate(lines) if line.startswith('{"type":"scan"')]
    ends = [scans[round(share * (len(scans) - 1) * i / parts)] for i in range(parts + 1)]
    logs = []
    for i in range(parts):
        logs.append(folder / f"part-{i}.jsonl")
        # Odometry comes before a scan of the same time.
        logs[-1].write_text("".join(lines[:1] + lines[max(1, ends[i] - 1) : ends[i + 1] + 1]))
    return logs


def at(building, share, parts):
    folder = building.folder / f"noise-{share:.1f}"
    folder.mkdir(exist_ok=True)
    log = disturbed(building.robots[0] / "log.jsonl", share, random.Random(f"noise {building.seed}"), folder / "log.jsonl")
    maps, drives = [], []
    for i, part in enumerate(cut(log, building.share, parts, folder)):
        run(building.tool, "slam", part, "-o", folder / f"map-{i}")
        maps.append(folder / f"map-{i}" / "map.yaml")
        drives.append(timed(folder / f"map-{i}" / "trajectory.txt"))
    links = [list(drive.values())[-1] for drive in drives[:-1]]
    chain = [(0j, 0.0)]
    for link in links:
        chain.append(times(chain[-1], link))
    truth = timed(building.robots[0] / "truth.txt")
    found = {"chain": error(drives, chain, truth)}
    clicks = building.written(clicks_in(building, maps[0]), f"noise-{share:.1f}")
    for mode in ("full", "acg"):
        report = json.loads(run(building.tool, "prior", "fit", building.plan.geojson, *maps, "--pairs", clicks, "--json",
                                "--mode", mode, "-o", folder / mode))
        places = chain[:1]
        for link, one in zip(links, report["inputs"][1:]):
            if one["accepted"]:
                x, y, yaw = one["T_first_input"]
                places.append((complex(x, y), yaw))
            else:
                places.append(times(places[-1], link))
        joined = sum(one["accepted"] for one in report["inputs"][1:])
        found[mode] = error(drives, places, truth) | {"joined": joined, "of": parts - 1}
    return found


def timed(path):
    return dict(zip((line.split()[0] for line in path.read_text().splitlines()), read_poses(path)))


def error(drives, places, truth):
    """m, of all poses in the frame of the first."""
    start = next(iter(truth.values()))
    squares = [abs(times(place, pose)[0] - between(start, truth[time])[0]) ** 2
               for drive, place in zip(drives, places) for time, pose in drive.items()]
    return {"rms_m": round(math.sqrt(sum(squares) / len(squares)), 4), "worst_m": round(math.sqrt(max(squares)), 3)}


def clicks_in(building, first):
    """On two corners that the first map has seen, 8 m apart, or else the two that are farthest apart."""
    plan = building.plan
    seen = Sight(plan, Cells(Raster(first).walls())).corners_of["seen"]
    pairs = sorted((abs(plan.true[a] - plan.true[b]), a, b) for a in seen for b in seen if a < b)
    far = [pair for pair in pairs if pair[0] >= BASELINE] or pairs[-1:]
    return building.pairs(random.Random(building.number), [pair[1:] for pair in far])
