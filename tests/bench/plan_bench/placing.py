# SPDX-License-Identifier: Apache-2.0
"""How well a plan is placed and corrected: by two clicks in each mode, and by itself."""
from .files import mirror_png

MODES = ("clicks", "similarity", "affine", "acg", "full")


def measure(building, mode):
    if mode == "clicks":
        places = by_clicks(building)
    else:
        places, _, _ = building.fitted(mode=mode)
    return building.sight.medians(places)


def by_clicks(building):
    """The similarity through both clicks; of the two, straight and mirrored, the better one."""
    (p, q), (r, s) = building.clicks
    best = None
    for straight in (True, False):
        def turned(point):
            return point.conjugate() if straight else point
        factor = (s - q) / (turned(r) - turned(p))
        places = [(turned(point) - turned(p)) * factor + q for point in building.plan.sheet]
        if best is None or seen_error(building, places) < seen_error(building, best):
            best = places
    return best


def seen_error(building, places):
    return building.sight.medians(places)["corners"]["seen"]


def by_itself(building):
    """From the picture of the plan, and from one in which left is right."""
    plan = building.plan
    found = by_picture(building, plan.picture, plan.sheet, plan.mirrored)
    flipped = building.folder / "mirrored.png"
    width = mirror_png(plan.picture, flipped)
    found["copy"] = by_picture(building, flipped, [complex(width - 1 - p.real, p.imag) for p in plan.sheet],
                               not plan.mirrored)
    true = plan.true
    found["plan_m2"] = round((max(p.real for p in true) - min(p.real for p in true)) *
                             (max(p.imag for p in true) - min(p.imag for p in true)))
    drive = building.poses[: int(building.share * len(building.poses))]
    found["driven_m"] = round(sum(abs(b[0] - a[0]) for a, b in zip(drive, drive[1:])), 1)
    return found


def by_picture(building, picture, sheet, mirrored):
    places, report, _ = building.fit(picture, [building.map / "map.yaml"], sheet, out="by-itself")
    found = {key: report[key] for key in ("accepted", "reason", "explained", "contradicted", "rival_ratio", "seconds")}
    if report["accepted"]:
        found["told_mirrored"] = report["mirrored"] == mirrored
    return found | building.sight.judged(places)
