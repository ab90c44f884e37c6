# SPDX-License-Identifier: Apache-2.0
"""On the server of ENFILADE_SERVER, a new site for each building: a plan in the maps into which a robot splits its drive,
and two maps that nothing but the plan joins."""
import cmath
import json
import math
import os
import statistics
import time

from .files import part_of, read_poses, run
from .plan import RIGHT


def tool_on(building, site):
    def tool(*words):
        return run(building.tool, "--json", "--timeout", 300, *words, env={**os.environ, "ENFILADE_SITE": site})
    tool("site", "create", site)
    return tool


def placed(building):
    """As the plan was placed, before its walls are moved one by one."""
    tool = tool_on(building, f"prior-{building.seed}-{os.getpid()}")
    tool("robot", building.log, "--robot", "robot", "--map", "Start", "--spool", building.folder / "spool", "--wait")
    tool("prior", "add", building.plan.picture, "--name", "plan")
    report = json.loads(tool("prior", "align", "plan"))
    found = {"accepted": report["accepted"], "reason": report["reason"]}
    if not report["accepted"]:
        return found
    found["maps"] = len(report["alignment"]["maps"])
    a, b, c, d, e, f = report["alignment"]["affine_world_sheet"]
    places = [complex(a * p.real + b * p.imag + c, d * p.real + e * p.imag + f) for p in building.plan.sheet]
    return found | building.sight.judged(places)


def tied(building):
    """Where the second robot's map lies in the first one's, by the plan in use."""
    second = building.robots[1]
    log = part_of(second / "log.jsonl", 0.0, building.share, building.folder / "second.jsonl")
    tool = tool_on(building, f"ties-{building.seed}-{os.getpid()}")
    tool("map", "import", building.map / "map.yaml", "--map", "first")
    tool("map", "import", building.mapped(log) / "map.yaml", "--map", "second")
    tool("prior", "add", building.plan.picture, "--name", "plan")
    report = json.loads(tool("prior", "align", "plan", "--activate"))
    found = {"accepted": report["accepted"] and bool(report["alignment"]["joined_maps"]), "reason": report["reason"]}
    if not found["accepted"]:
        return found
    found["tied_walls"] = report["alignment"]["tied_walls"]
    drive = read_poses(second / "truth.txt")
    start, yaw = drive[0]
    middle = statistics.fmean(p.real for p, _ in drive), statistics.fmean(p.imag for p, _ in drive)
    at = (complex(*middle) - start) * cmath.rect(1, -yaw)
    for _ in range(100):
        pose = json.loads(tool("pose", "global", "--at", f"second,{at.real},{at.imag},0"))
        if pose.get("pose_world_robot"):
            break
        time.sleep(0.2)
    else:
        return found | {"state": json.loads(tool("prior", "show", "plan"))["reason"]}
    return found | off_by(pose["pose_world_robot"], building.to_map(complex(*middle)), yaw - building.poses[0][1])


def off_by(pose, true, true_yaw):
    error = complex(pose["x"], pose["y"]) - true
    off = (pose["yaw"] - true_yaw + math.pi) % (2 * math.pi) - math.pi
    a, b, d = pose["covariance"][0], pose["covariance"][1], pose["covariance"][4]
    surprise = (d * error.real ** 2 - 2 * b * error.real * error.imag + a * error.imag ** 2) / (a * d - b * b)
    return {"error_m": round(abs(error), 4), "error_rad": round(abs(off), 5), "sigmas": round(math.sqrt(surprise), 2),
            "right": abs(error) <= RIGHT}
