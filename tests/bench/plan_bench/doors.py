# SPDX-License-Identifier: Apache-2.0
"""Where are the doors, by the corrected plan? By their number, from the drawing; and how many of the building's doors the
picture of the plan gives."""
import json
import math

from .plan import median

CHI2_95 = 5.991  # 2 degrees of freedom
SAME = 1.0  # m: a door so near to a true one is that
NEAR_SEEN = 0.5  # m


def measure(building):
    true = true_doors(building)
    _, _, folder = building.fitted()
    predicted = doors_of(folder)
    found = []
    for (a, b), (place, properties) in zip(true, predicted):
        middle = (a + b) / 2
        error = place - middle
        surprise = (abs(error) / properties["sigma_m"]) ** 2  # the standard deviation is that of the worst direction
        seen = all(building.walls.has(end, NEAR_SEEN) for end in (a, b))
        found.append({"seen": seen, "error_m": round(abs(error), 3), "sigmas": round(math.sqrt(surprise), 2),
                      "within": surprise <= CHI2_95})
    _, _, folder = building.fit(building.plan.picture, [building.map / "map.yaml"], building.plan.sheet, "--pairs",
                                building.written(building.clicks), out="doors")
    drawn = [place for place, _ in doors_of(folder)]
    pairs = matched(drawn, [(a + b) / 2 for a, b in true])
    return {"doors": found, "drawn": len(drawn), "true": len(true), "both": pairs}


def true_doors(building):
    exact = building.exact()
    transform = exact.truth("similarity")
    return [[transform(end) for end in door] for door in exact.door_sheet]


def doors_of(folder):
    """Their middles, and what is said of them."""
    doors = [one for one in json.loads((folder / "walls.geojson").read_text())["features"]
             if one["properties"]["kind"] == "door"]
    return [(sum(complex(*end) for end in one["geometry"]["coordinates"]) / 2, one["properties"]) for one in doors]


def matched(predicted, true):
    """How many are one another's, the nearest first."""
    near = sorted((abs(p - q), i, k) for i, p in enumerate(predicted) for k, q in enumerate(true) if abs(p - q) <= SAME)
    used, taken = set(), set()
    for _, i, k in near:
        if i not in used and k not in taken:
            used.add(i)
            taken.add(k)
    return len(used)


def summary(found):
    result = {}
    for name in (True, False):
        doors = [door for one in found for door in one["doors"] if door["seen"] == name]
        result["seen" if name else "unseen"] = {
            "doors": len(doors), "median_m": median([door["error_m"] for door in doors]),
            "p90_m": sorted(door["error_m"] for door in doors)[int(0.9 * len(doors))] if doors else None,
            "within_95": round(sum(door["within"] for door in doors) / len(doors), 3) if doors else None}
    both = sum(one["both"] for one in found)
    result["precision"] = round(both / max(1, sum(one["drawn"] for one in found)), 3)
    result["recall"] = round(both / max(1, sum(one["true"] for one in found)), 3)
    return result
