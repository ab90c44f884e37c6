# SPDX-License-Identifier: Apache-2.0
"""Maps in a chain, of a robot whose odometry is bad: how far are its poses off, with and without the plan? The odometry is
disturbed as the Auto-Complete Graph's authors do, but before anything is computed, and errors add up: of each 0.5 m, both
x and y are off by +-p of the way, and the turn is longer or shorter by p. The drive is cut into parts. Each is mapped by
itself, without closing loops with the others, and begins where the one before ends: that is the chain without a plan. With
it, `enfilade prior fit` joins the maps, each of which it looks for by itself; one that it leaves out stays where the chain has
it, behind the one before. On a site the links of the chain are link points, and the plan is put to use."""
import cmath
import json
import math
import os
import random

from . import linear, site
from .building import BASELINE
from .files import Raster, read_poses, run
from .plan import Cells, Sight

STRIDE = 0.5  # m
LINK_SIGMA = 0.03, math.radians(1)  # m, rad: how well a link point of the chain says that it knows it
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


class Chain:
    """Maps of parts of the drive, and where each lies in the first if it begins where the one before ends."""

    def __init__(self, building, share, parts):
        self.folder = building.folder / f"noise-{share:.1f}-{parts}"
        self.folder.mkdir(exist_ok=True)
        self.truth = timed(building.robots[0] / "truth.txt")
        log = disturbed(building.robots[0] / "log.jsonl", share, random.Random(f"noise {building.seed}"),
                        self.folder / "log.jsonl")
        folders = [building.made(self.folder / f"map-{i}", "slam", part)
                   for i, part in enumerate(cut(log, building.share, parts, self.folder))]
        self.maps = [folder / "map.yaml" for folder in folders]
        self.drives = [timed(folder / "trajectory.txt") for folder in folders]
        self.links = [list(drive.values())[-1] for drive in self.drives[:-1]]
        self.places = [(0j, 0.0)]
        for link in self.links:
            self.places.append(times(self.places[-1], link))

    def error(self, places):
        """m, of all poses: in the frame of the first, and after the turn and shift that fit best."""
        start = next(iter(self.truth.values()))
        pairs = [(times(place, pose)[0], between(start, self.truth[time])[0])
                 for drive, place in zip(self.drives, places) for time, pose in drive.items()]
        off = [abs(found - true) for found, true in pairs]
        turned = linear.best([found for found, _ in pairs], [true for _, true in pairs], "similarity", True)
        turned.a /= abs(turned.a)
        turned.c = sum(true - turned.a * found for found, true in pairs) / len(pairs)
        return {"rms_m": rms(off), "worst_m": round(max(off), 3), "ate_m": rms(abs(turned(found) - true) for found, true in pairs)}


def rms(values):
    values = list(values)
    return round(math.sqrt(sum(value * value for value in values) / len(values)), 4)


def at(building, share, parts):
    chain = Chain(building, share, parts)
    found = {"chain": chain.error(chain.places)}
    clicks = building.written(clicks_in(building, chain.maps[0]), f"noise-{share:.1f}")
    for mode in ("full", "acg"):
        report = json.loads(run(building.tool, "prior", "fit", building.plan.geojson, *chain.maps, "--pairs", clicks, "--json",
                                "--mode", mode, "-o", chain.folder / mode))
        places = chain.places[:1]
        for link, one in zip(chain.links, report["inputs"][1:]):
            if one["accepted"]:
                x, y, yaw = one["T_first_input"]
                places.append((complex(x, y), yaw))
            else:
                places.append(times(places[-1], link))
        joined = sum(one["accepted"] for one in report["inputs"][1:])
        found[mode] = chain.error(places) | {"joined": joined, "of": parts - 1}
    return found


def on_a_site(building, shares, parts):
    """On the server: link points join each map with the next, and the plan is put to use."""
    return {f"{share:.1f}": linked(building, Chain(building, share, parts), share) for share in shares}


def link_point(name, maps, link):
    """A change of the graph: where the second map begins in the first one."""
    shares = [LINK_SIGMA[0] ** 2 / 2] * 2 + [LINK_SIGMA[1] ** 2 / 2]
    covariance = [shares[0], 0, 0, 0, shares[1], 0, 0, 0, shares[2]]

    def anchor(of_map, place, yaw):
        pose = {"x": place.real, "y": place.imag, "yaw": yaw}
        return {"map": of_map, "poseMapPlace": {"pose": pose, "covariance": covariance}}
    return {"created": {"name": name, "kind": "KIND_OPENING", "anchors": [anchor(maps[0], *link), anchor(maps[1], 0j, 0.0)]}}


def solved_places(tool, names):
    """Of maps of a site in the world, once its graph is solved."""
    tool("graph", "optimize")
    poses = [json.loads(tool("pose", "global", "--at", f"{name},0,0,0"))["pose_world_robot"] for name in names]
    return [(complex(pose["x"], pose["y"]), pose["yaw"]) for pose in poses]


def linked(building, chain, share):
    of_site = f"chain-{building.seed}-{100 * share:.0f}-{os.getpid()}"
    tool = site.tool_on(building, of_site)
    names = [f"part{i}" for i in range(len(chain.maps))]
    for name, map_yaml in zip(names, chain.maps):
        tool("map", "import", map_yaml, "--map", name)
    of_name = {one["display_name"]: one["name"] for one in json.loads(tool("map", "list"))}
    changes = building.folder / "links.json"
    changes.write_text(json.dumps({"changes": [
        link_point(f"sites/{of_site}/linkPoints/{b}", (of_name[a], of_name[b]), link)
        for a, b, link in zip(names, names[1:], chain.links)]}))
    tool("graph", "change", changes)

    found = {"chain": chain.error(solved_places(tool, names))}
    clicks = building.written(clicks_in(building, chain.maps[0]), f"site-{share:.1f}")
    tool("prior", "add", building.plan.geojson, "--name", "plan")
    report = json.loads(tool("prior", "align", "plan", "--pairs", clicks, "--activate"))
    found["plan"] = {"accepted": report["accepted"], "reason": report["reason"]}
    if report["accepted"]:
        found["full"] = chain.error(solved_places(tool, names))
        state = json.loads(tool("prior", "show", "plan"))
        found["plan"] |= {"state": state["state"], "reason": state["reason"], "maps": len(report["alignment"]["maps"])}
    return found


def timed(path):
    return dict(zip((line.split()[0] for line in path.read_text().splitlines()), read_poses(path)))


def clicks_in(building, map_yaml, place=(0j, 0.0)):
    """In the map's frame, on two corners that it has seen, 8 m apart, or else the two that are farthest apart. `place`: where
    the map lies in that of the whole drive."""
    plan = building.plan
    walls = Cells(times(place, (wall, 0.0))[0] for wall in Raster(map_yaml).walls())
    seen = Sight(plan, walls).corners_of["seen"]
    pairs = sorted((abs(plan.true[a] - plan.true[b]), a, b) for a in seen for b in seen if a < b)
    far = [pair for pair in pairs if pair[0] >= BASELINE] or pairs[-1:]
    clicks = building.pairs(random.Random(building.number), [pair[1:] for pair in far])
    return [(on_sheet, between(place, (in_map, 0.0))[0]) for on_sheet, in_map in clicks]
