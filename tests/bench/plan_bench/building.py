# SPDX-License-Identifier: Apache-2.0
"""A random building: a drive through it, maps of it, plans of it."""
import cmath
import json
import random

from .files import Raster, part_of, read_poses, run
from .plan import Cells, Plan, Sight

CLICK_SIGMA = 0.3  # m
BASELINE = 8.0  # m, least between two clicks


class Building:
    """Whatever is already in the folder is used again. `errors` and `drive`: more options of `enfilade simulate`, for the
    plan and for the drive."""

    def __init__(self, tool, seed, share, folder, errors=(), drive=()):
        self.tool, self.seed, self.share, self.folder = tool, seed, share, folder
        self.campus = f"random:{seed}" if isinstance(seed, int) else seed
        self.number = seed if isinstance(seed, int) else 1
        self.made(folder / "drive", "simulate", self.campus, "--seed", self.number, *drive)
        self.robots = sorted(path for path in (folder / "drive").iterdir() if (path / "log.jsonl").exists())
        self.poses = read_poses(self.robots[0] / "truth.txt")
        self.log = self.part(0.0, share)
        self.map = self.mapped(self.log)
        self.raster = Raster(self.map / "map.yaml")
        self.walls = Cells(self.raster.walls())
        self.plan = self.drawn(*errors)
        self.sight = Sight(self.plan, self.walls)
        self.clicks = self.pairs(random.Random(seed), self.far_apart(BASELINE))

    def to_map(self, place):
        """From the campus into the map's frame, which is where the robot was switched on."""
        start, yaw = self.poses[0]
        return (place - start) * cmath.rect(1, -yaw)

    def made(self, folder, *words):
        """The folder that a command has filled, perhaps earlier."""
        if not (folder / "made").exists():
            run(self.tool, *words, "-o", folder)
            (folder / "made").touch()
        return folder

    def part(self, begin, end):
        return part_of(self.robots[0] / "log.jsonl", begin, end, self.folder / f"{begin:.3f}-{end:.3f}.jsonl")

    def mapped(self, log):
        return self.made(self.folder / f"map-{log.stem}", "slam", log)

    def drawn(self, *errors):
        """A plan that is drawn wrong: other options of `simulate`, which begin with --plan."""
        folder = self.folder / "-".join(["plan", *(str(word).lstrip("-") for word in errors)])
        self.sketch(folder, "--plan-deform", self.number, *errors)
        return Plan(folder, self.to_map)

    def exact(self):
        self.sketch(self.folder / "exact")
        return Plan(self.folder / "exact", self.to_map)

    def sketch(self, folder, *words):
        # The drive that comes with it is as short as can be.
        self.made(folder.with_name(folder.name + "-drive"), "simulate", self.campus, "--seed", self.number, "--plan-out",
                  folder, "--robots", self.robots[0].name, "--beams", 8, "--scan-hz", 0.1, *words)

    def far_apart(self, least, most=1e9):
        """Pairs of corners that robots have seen."""
        seen, true = self.sight.corners_of["seen"], self.plan.true
        return [(a, b) for a in seen for b in seen if least <= abs(true[a] - true[b]) <= most]

    def pairs(self, rng, choices, plan=None):
        """Clicks on the corners of one choice: on the sheet, and about there in the map."""
        plan = plan or self.plan
        return [(plan.sheet[i], plan.true[i] + complex(rng.gauss(0, CLICK_SIGMA), rng.gauss(0, CLICK_SIGMA)))
                for i in rng.choice(choices)]

    def written(self, pairs, name="pairs"):
        path = self.folder / f"{name}.csv"
        path.write_text("".join(f"{p.real},{p.imag},{q.real},{q.imag}\n" for p, q in pairs))
        return path

    def fit(self, plan, maps, points, *options, out="fit"):
        """Where the points (of the sheet) lie, or None; what the program says; and its folder."""
        path = self.folder / f"{out}-points.csv"
        path.write_text("".join(f"{point.real},{point.imag}\n" for point in points))
        folder = self.folder / out
        report = json.loads(run(self.tool, "prior", "fit", plan, *maps, "--points", path, "-o", folder, "--json", *options))
        if not report["accepted"]:
            return None, report, folder
        rows = [line.split(",") for line in (folder / "points.csv").read_text().splitlines()[1:]]
        return [complex(float(row[2]), float(row[3])) for row in rows], report, folder

    def fitted(self, plan=None, mode="full"):
        """By two clicks. Kept for the other measurements of this run."""
        plan = plan or self.plan
        known = self.__dict__.setdefault("fits", {})
        key = (plan.geojson, mode)
        if key not in known:
            clicks = self.clicks if plan is self.plan else self.clicked_on(plan)
            out = f"fit-{plan.geojson.parent.name}-{mode}"
            known[key] = self.fit(plan.geojson, [self.map / "map.yaml"], plan.sheet, "--pairs", self.written(clicks, out),
                                  "--mode", mode, out=out)
        return known[key]

    def clicked_on(self, plan):
        """Two clicks on another plan."""
        sight = Sight(plan, self.walls)
        seen = sight.corners_of["seen"]
        apart = [(a, b) for a in seen for b in seen if abs(plan.true[a] - plan.true[b]) >= BASELINE]
        return self.pairs(random.Random(self.number), apart, plan)
