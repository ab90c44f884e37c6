# SPDX-License-Identifier: Apache-2.0
"""Sessions in any order, on the server of ENFILADE_SERVER: does a site with a plan end at the same solution? The drive is cut
into sessions, each of which has a map of its own. They come one by one. A link point joins each with its neighbours as soon as
these are there. The plan is placed by two clicks on the first map that comes, put to use, and aligned again after each further
one."""
import itertools
import json
import os
import random

from . import noise, site

SESSIONS = 4


def measure(building, count):
    """`count` orders, with the drive's own among them."""
    chain = noise.Chain(building, 0.0, SESSIONS)
    orders = list(itertools.permutations(range(SESSIONS)))
    chosen = orders[:1] + random.Random(f"orders {building.seed}").sample(orders[1:], count - 1)
    found = {"".join(map(str, order)): after(building, chain, order) for order in chosen}
    solutions = [one["places"] for one in found.values() if one["accepted"]]
    pairs = [pair for two in itertools.combinations(solutions, 2) for pair in zip(*two)]
    return {"orders": len(chosen), "accepted": len(solutions),
            "apart_m": round(max((abs(a[0] - b[0]) for a, b in pairs), default=0.0), 5),
            "apart_rad": round(max((abs(noise.wrapped(a[1] - b[1])) for a, b in pairs), default=0.0), 5),
            "ate_m": [one["ate_m"] for one in found.values()],
            "reasons": [one["reason"] for one in found.values() if not one["accepted"]]}


def after(building, chain, order):
    of_site = f"orders-{building.seed}-{''.join(map(str, order))}-{os.getpid()}"
    tool = site.tool_on(building, of_site)
    names = {}
    for part in order:
        tool("map", "import", chain.maps[part], "--map", f"part{part}")
        names = {one["display_name"]: one["name"] for one in json.loads(tool("map", "list"))}
        for a in (part - 1, part):
            if {f"part{a}", f"part{a + 1}"} <= set(names):
                change = building.folder / "link.json"
                change.write_text(json.dumps({"changes": [noise.link_point(
                    f"sites/{of_site}/linkPoints/{a}", (names[f"part{a}"], names[f"part{a + 1}"]), chain.links[a])]}))
                tool("graph", "change", change)
        if len(names) == 1:
            tool("prior", "add", building.plan.geojson, "--name", "plan")
            clicks = building.written(noise.clicks_in(building, chain.maps[part], chain.places[part]), f"order-{part}")
            report = json.loads(tool("prior", "align", "plan", "--pairs", clicks, "--activate"))
        else:
            report = json.loads(tool("prior", "align", "plan", "--from-last", "--activate"))
        if not report["accepted"]:
            return {"accepted": False, "reason": report["reason"], "ate_m": None}
        tool("graph", "optimize")
    poses = noise.solved_places(tool, [f"part{part}" for part in range(SESSIONS)])
    relative = [noise.between(poses[0], pose) for pose in poses]
    return {"accepted": True, "reason": report["reason"], "ate_m": chain.error(relative)["ate_m"],
            "places": relative}
