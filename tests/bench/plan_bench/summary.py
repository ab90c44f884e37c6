# SPDX-License-Identifier: Apache-2.0
"""What all buildings say together."""
import statistics

from . import doors
from .plan import CLASSES, median


def share(found, of):
    return round(found / of, 3) if of else None


def of_places(mode, found):
    result = {}
    for what in ("walls", "walls_p95", "corners"):
        result[what] = {name: median([one[what][name] for one in found if one[what][name] is not None]) for name in CLASSES}
    return result


def of_places_found(mode, found):
    """Of `by_itself`, `site`, `ties`."""
    result = {"of": len(found), "accepted": sum(one["accepted"] for one in found),
              "right": sum(one.get("right", False) for one in found)}
    for key in ("error_m", "error_rad", "sigmas", "seconds"):
        values = [one[key] for one in found if key in one]
        if values:
            result[key] = {"median": statistics.median(values), "worst": max(values)}
    copies = [one["copy"] for one in found if "copy" in one]
    if copies:
        accepted = [one for one in found + copies if one["accepted"]]
        result["copies"] = {"accepted": sum(one["accepted"] for one in copies),
                            "right": sum(one.get("right", False) for one in copies)}
        result["wrong_accepted"] = sum(not one["right"] for one in accepted)
        result["told_whether_mirrored"] = f"{sum(one['told_mirrored'] for one in accepted)}/{len(accepted)}"
        result["seconds_per_5000_m2"] = median([5000 * one["seconds"] / one["plan_m2"] for one in found])
    return result


def of_pairs(mode, found):
    groups = {}
    for one in found:
        for placed in one["placed"]:
            groups.setdefault(f"{placed['plan']}, {placed['baseline']}, {placed['pairs']} pairs", []).append(placed)
    result = {}
    for name, of in sorted(groups.items()):
        fitted = [one for one in of if "refused" not in one]
        result[name] = {"right": sum(one["right"] for one in fitted), "of": len(fitted), "refused": len(of) - len(fitted),
                        "turn_deg": median([abs(one["turn_deg"]) for one in fitted]),
                        "growth": median([abs(one["growth"]) for one in fitted])}
    wrong = [one for of in found for one in of["wrong"]]
    return result | {"wrong one named": f"{sum(one['right'] for one in wrong)}/{len(wrong)}"}


def of_coverage(mode, found):
    steps = [step for one in found for step in one["steps"]]
    by_share = {}
    for one in found:
        for at in one.get("errors", ()):
            by_share.setdefault(at["share"], []).append(at)
    return {"steps": len(steps), "grow": sum(step["grows"] for step in steps),
            "unseen_m": {str(key): median([at["unseen_m"] for at in of if at["unseen_m"] is not None])
                         for key, of in by_share.items()},
            "seen": {str(key): median([at["seen"] for at in of]) for key, of in by_share.items()},
            "same_walls_m": [median([step["error_m"][k] for step in steps]) for k in (0, 1)]}


def of_noise(mode, found):
    result = {}
    for level in found[0] if found else ():
        here = [one[level] for one in found]
        result[level] = {name: median([one[name]["ate_m"] for one in here]) for name in ("chain", "full", "acg")}
        result[level]["worst"] = {name: max(one[name]["ate_m"] for one in here) for name in ("chain", "full", "acg")}
        result[level]["joined"] = share(sum(one["full"]["joined"] for one in here), sum(one["full"]["of"] for one in here))
        result[level]["acg_joined"] = share(sum(one["acg"]["joined"] for one in here), sum(one["acg"]["of"] for one in here))
        result[level]["better"] = sum(one["full"]["ate_m"] <= 1.02 * one["chain"]["ate_m"] + 0.005 for one in here)
    return result


def of_orders(mode, found):
    """Solutions that differ by less than a millimetre are the same; the unit is in the names."""
    whole = [one for one in found if one["accepted"] == one["orders"]]
    return {"of": len(found), "placed_in_all_orders": len(whole), "same": sum(one["apart_m"] <= 0.001 for one in whole),
            "apart_m": {"median": median([one["apart_m"] for one in whole]),
                        "worst": max((one["apart_m"] for one in whole), default=None)}}


def of_chain(mode, found):
    result = {}
    for level in found[0] if found else ():
        here = [one[level] for one in found]
        # A plan that is not in use leaves the chain as it is.
        pairs = [(one["chain"]["ate_m"], one.get("full", one["chain"])["ate_m"]) for one in here]
        result[level] = {"chain": median([a for a, _ in pairs]), "full": median([b for _, b in pairs]),
                         "worst": [max(values) for values in zip(*pairs)], "of": len(here),
                         "used": sum(one["plan"].get("state") == "active" for one in here),
                         "halved": sum(b <= 0.5 * a for a, b in pairs),
                         "never_worse": sum(b <= 1.02 * a + 0.005 for a, b in pairs)}
    return result


def of_associations(mode, found):
    total = {key: sum(one[key] for one in found) for key in found[0] if key != "wrong"} if found else {}
    if not total:
        return {}
    return total | {"precision": share(total["true_claims"], total["claimed"]),
                    "precision_of_what_stands": share(total["true_claims"] + total["claims_that_stand"], total["claimed"]),
                    "recall": share(total["found"], total["observable"]),
                    "contradicted_precision": share(total["true_contradicted"], total["contradicted"]),
                    "contradicted_recall": share(total["found_contradicted"], total["contradictable"])}


def of_routes(mode, found):
    goals = [goal for one in found for goal in one["goals"]]
    both = [goal for goal in goals if goal["planned_m"] is not None and goal["true_m"] is not None]
    agree = sum((goal["planned_m"] is None) == (goal["true_m"] is None) for goal in goals)
    ratios = [goal["planned_m"] / goal["true_m"] for goal in both if goal["true_m"] > 0]
    return {"goals": len(goals), "agree": agree, "reached_in_truth": sum(goal["true_m"] is not None for goal in goals),
            "both": len(both), "within_10_percent": sum(abs(ratio - 1) <= 0.1 for ratio in ratios),
            "ratio": median(ratios), "cells": sum(one["cells"] for one in found),
            "changed": sum(one["changed"] for one in found), "wrong_mask": sum(one["wrong_mask"] for one in found),
            "on_lattice": sum(one["on_lattice"] for one in found)}


OF = {"by_itself": of_places_found, "site": of_places_found, "ties": of_places_found, "pairs": of_pairs,
      "coverage": of_coverage, "noise": of_noise, "chain": of_chain, "orders": of_orders, "associations": of_associations, "usual_associations": of_associations,
      "doors": lambda mode, found: doors.summary(found), "routes": of_routes}


def of(mode, buildings):
    found = [one[mode] for one in buildings if mode in one]
    return OF.get(mode, of_places)(mode, found)
