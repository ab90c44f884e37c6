# SPDX-License-Identifier: Apache-2.0
"""A hall of 9 m x 6 m, whose left wall has niches, and what a robot records in it."""
import math

START_S = 1_700_000_000
BEAMS = 120
WIDTH_M, HEIGHT_M = 9.0, 6.0
START_M = (2.0, 2.5)  # of the robot; it drives along x


def scan(step):
    """What it sees when it has driven `step` times 0.1 m."""
    x, y = START_M[0] + 0.1 * step, START_M[1]
    ranges = []
    for beam in range(BEAMS):
        angle = 2 * math.pi * beam / BEAMS
        c, s = math.cos(angle), math.sin(angle)
        hits = ([(w - x) / c for w in (0.0, WIDTH_M) if abs(c) > 1e-9] +
                [(w - y) / s for w in (0.0, HEIGHT_M) if abs(s) > 1e-9])
        distance = min(h for h in hits if h > 0)
        ranges.append(distance + (0.7 if 20 < beam < 26 else 0.0))
    return {"time": {"seconds": START_S + step}, "angle_increment_rad": 2 * math.pi / BEAMS, "range_min_m": 0.05,
            "range_max_m": 30.0, "ranges_m": ranges}


def odometry(step):
    return {"time": {"seconds": START_S + step}, "pose_odom_robot": {"x": 0.1 * step}}
