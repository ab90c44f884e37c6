# SPDX-License-Identifier: Apache-2.0
"""Which walls of the plan does the program say it has seen, and which are not there? By the number of the wall, with a
fifth of the walls left out of the plan and as many invented, in a furnished building with people."""
import json

from .plan import STEP, median

ERRORS = ("--plan-left-out", 0.2, "--plan-invented", 0.2)
OBSERVABLE = 0.8  # m that were seen
ON_WALL = 0.3  # m: a wall that is placed so near to where it is was taken for itself
BENT = 0.2  # m
FREE = 0.5  # share: of an invented wall, in ground that the map knows to be free
STANDS = 0.5  # share: of an invented wall, where the building has a wall that the plan leaves out
PARALLEL = 0.95  # cosine


def measure(building, errors=ERRORS):
    plan = building.drawn(*errors)
    places, _, folder = building.fitted(plan)
    walls = [one for one in json.loads((folder / "walls.geojson").read_text())["features"]
             if one["properties"]["kind"] == "wall"]
    counts = {"claimed": 0, "true_claims": 0, "claims_that_stand": 0, "observable": 0, "found": 0, "contradicted": 0, "true_contradicted": 0,
              "contradictable": 0, "found_contradicted": 0, "rest": 0, "bent": 0}
    wrong = []
    real = 0  # index among walls that are not invented
    for number, (ends, invented, wall) in enumerate(zip(plan.all_walls, plan.invented, walls)):
        state = wall["properties"]["state"]
        length = abs(plan.true[ends[1]] - plan.true[ends[0]])
        claims = state == "seen" or wall["properties"]["seen"] * length >= OBSERVABLE
        if invented:
            visible = looked_through(building, plan, ends)
            counts["contradictable"] += visible
            counts["found_contradicted"] += visible and state == "contradicted"
            counts["claimed"] += claims
            counts["claims_that_stand"] += claims and stands(plan, ends)
        else:
            seen = [place for place in plan.along(ends) if building.walls.has(place)]
            off = median([plan.across(places, (real, place)) for place in seen])
            right = bool(seen) and off <= ON_WALL
            observable = len(seen) * STEP >= OBSERVABLE
            counts["claimed"] += claims
            counts["true_claims"] += claims and right
            counts["observable"] += observable
            counts["found"] += observable and claims and right
            counts["rest"] += observable
            counts["bent"] += observable and off > BENT
            real += 1
        counts["contradicted"] += state == "contradicted"
        counts["true_contradicted"] += state == "contradicted" and invented
        if (claims and (invented or not right)) or (state == "contradicted" and not invented):
            wrong.append({"wall": number, "invented": invented, "state": state, "off_m": None if invented else off})
    return counts | {"wrong": wrong}


def looked_through(building, plan, ends):
    """Has the robot seen free ground where an invented wall is drawn?"""
    cells = [building.raster.index(place) for place in plan.along(ends)]
    return sum(cell is not None and building.raster.cells[cell] == 0 for cell in cells) > FREE * len(cells)


def stands(plan, ends):
    """Is there such a wall, though the plan means none? Walls are invented beside those that are drawn, without regard to
    those that are left out."""
    along = plan.true[ends[1]] - plan.true[ends[0]]
    places = plan.along(ends)
    return sum(any(runs_there(place, along, wall) for wall in plan.left_out) for place in places) >= STANDS * len(places)


def runs_there(place, along, wall):
    way = wall[1] - wall[0]
    length = abs(way)
    if length == 0 or abs((along * way.conjugate()).real) < PARALLEL * abs(along) * length:
        return False
    at = (place - wall[0]) * way.conjugate() / length
    return 0 <= at.real <= length and abs(at.imag) <= ON_WALL
