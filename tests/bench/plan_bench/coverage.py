# SPDX-License-Identifier: Apache-2.0
"""As a robot sees more, does what it has not seen become better? The same two clicks, on maps of more and more of the drive.
In each step the walls that neither map has seen are compared."""
import random

from .building import BASELINE
from .files import Raster
from .plan import Cells, Sight, median

SHARES = (0.2, 0.4, 0.6, 0.8, 1.0)
LEAST = 4  # samples: a metre of wall
GROWS = 1.1


def measure(building):
    plan = building.plan
    maps = [building.mapped(building.part(0.0, share)) for share in SHARES]
    sights = [Sight(plan, Cells(Raster(folder / "map.yaml").walls())) for folder in maps]
    seen = sights[0].corners_of["seen"]
    apart = [(a, b) for a in seen for b in seen if abs(plan.true[a] - plan.true[b]) >= BASELINE]
    if not apart:
        return {"steps": [], "why": "the first map has seen no two corners far enough apart"}
    clicks = building.written(building.pairs(random.Random(building.number), apart), "coverage")
    found = []
    for folder, sight in zip(maps, sights):
        places, _, _ = building.fit(plan.geojson, [folder / "map.yaml"], plan.sheet, "--pairs", clicks, out="coverage")
        found.append({"places": places, "sight": sight})
    steps = []
    for i in range(1, len(SHARES)):
        unseen = [one for name in ("near", "far") for one in found[i]["sight"].samples_of[name]
                  if not found[i - 1]["sight"].walls.has(one[1])]
        if len(unseen) < LEAST:
            continue
        errors = [median([plan.across(found[k]["places"], one) for one in unseen]) for k in (i - 1, i)]
        steps.append({"from": SHARES[i - 1], "to": SHARES[i], "unseen_m": len(unseen) / 4, "error_m": errors,
                      "grows": errors[1] > GROWS * errors[0]})
    errors = []
    for share, one in zip(SHARES, found):
        unseen = [sample for name in ("near", "far") for sample in one["sight"].samples_of[name]]
        seen_m = len(one["sight"].samples_of["seen"]) / max(1, len(plan.samples))
        errors.append({"share": share, "seen": round(seen_m, 3),
                       "unseen_m": median([plan.across(one["places"], sample) for sample in unseen])})
    return {"steps": steps, "errors": errors}
