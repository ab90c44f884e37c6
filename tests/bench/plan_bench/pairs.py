# SPDX-License-Identifier: Apache-2.0
"""What clicks are worth. The exact plan, turned and scaled by a similarity, and the plan that is drawn wrong, are placed
from two to five pairs that are 0.3 m off in each axis, the first two 4 to 5 m or 8 to 10 m apart. The turn and the scale
of the result are compared with those of the transform of the same kind that puts the corners that were seen best where they
are; of the exact plan this is the true one. And of five pairs one shows another place: is it named?"""
import cmath
import json
import random
import re
import subprocess

from .linear import Linear
from .plan import Sight

TURN = 0.2  # degrees
GROWTH = 0.005
WRONG = 3.0  # m, a wrong click is off at least
BASELINES = {"4 m": (4.0, 5.0), "8 m": (8.0, 10.0)}


def measure(building, trials):
    exact = building.exact()
    sight = Sight(exact, building.walls)
    rng = random.Random(f"pairs {building.seed}")
    found = []
    for trial in range(trials):
        for baseline, (least, most) in BASELINES.items():
            for kind, plan, of in (("exact", turned(exact, building, rng), sight), ("drawn", building.plan, building.sight)):
                seen = of.corners_of["seen"]
                choices = [(a, b) for a in seen for b in seen if least <= abs(plan.true[a] - plan.true[b]) <= most]
                if not choices:
                    continue
                first = list(rng.choice(choices))
                rest = rng.sample([i for i in seen if i not in first], 3)
                clicks = building.pairs(rng, [first + rest], plan)
                for count in (2, 3, 5) if baseline == "4 m" else (2,):
                    one = {"trial": trial, "baseline": baseline, "plan": kind, "pairs": count}
                    try:
                        found.append(one | placed(building, plan, seen, clicks[:count]))
                    except subprocess.CalledProcessError as error:  # nearer together than a twentieth of the plan
                        found.append(one | {"refused": error.stderr.strip()})
    return {"placed": found, "wrong": [wrong_one(building, rng) for _ in range(trials)]}


class Turned:
    """A plan on a sheet that is turned and scaled."""

    def __init__(self, plan, factor, path):
        document = json.loads(plan.geojson.read_text())

        def moved(place):
            if not isinstance(place[0], (int, float)):
                return [moved(one) for one in place]
            point = complex(*place) * factor
            return [point.real, point.imag]
        for one in document["features"]:
            one["geometry"]["coordinates"] = moved(one["geometry"]["coordinates"])
            if "thickness" in one["properties"]:
                one["properties"]["thickness"] *= abs(factor)
        path.write_text(json.dumps({key: value for key, value in document.items() if key != "metres_per_unit"}))
        self.geojson, self.true, self.mirrored = path, plan.true, plan.mirrored
        self.sheet = [point * factor for point in plan.sheet]
        self.exactly = plan.truth("similarity").times(Linear(1 / factor, 0, 0))

    def truth(self, model, corners):
        return self.exactly


def turned(plan, building, rng):
    factor = cmath.rect(rng.uniform(0.8, 1.25), rng.uniform(0, 2 * cmath.pi))
    return Turned(plan, factor, building.folder / "turned.geojson")


def placed(building, plan, corners, clicks):
    _, report, _ = building.fit(plan.geojson, [building.map / "map.yaml"], plan.sheet, "--pairs",
                                building.written(clicks, "some"), out="by-pairs")
    true = plan.truth(report["model"], corners)
    turn, growth = Linear.of_rows([report["A_input_plan"][:3], report["A_input_plan"][3:]]).times(true.inverse()).turn_and_growth()
    return {"model": report["model"], "turn_deg": round(turn, 3), "growth": round(growth, 5),
            "right": abs(turn) <= TURN and abs(growth) <= GROWTH}


def wrong_one(building, rng):
    """Is the one that shows another corner named, and no other?"""
    plan, seen = building.plan, building.sight.corners_of["seen"]
    while True:
        corners = rng.sample(seen, 5)
        wrong = rng.randrange(5)
        others = [i for i in seen if abs(plan.true[i] - plan.true[corners[wrong]]) >= WRONG]
        if others:
            break
    clicks = building.pairs(rng, [corners])
    clicks[wrong] = (clicks[wrong][0], building.pairs(rng, [[rng.choice(others)]])[0][1])
    _, report, _ = building.fit(plan.geojson, [building.map / "map.yaml"], plan.sheet, "--pairs",
                                building.written(clicks, "some"), out="by-pairs")
    named = re.search(r"pair (\d+) is", report["reason"])
    return {"named": int(named.group(1)) - 1 if named else None, "wrong": wrong,
            "right": named is not None and int(named.group(1)) - 1 == wrong,
            "off_m": round(abs(clicks[wrong][1] - plan.true[corners[wrong]]), 1)}
