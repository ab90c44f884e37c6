# SPDX-License-Identifier: Apache-2.0
"""What was called, how it was answered, and which answers should not have been."""
import collections
import threading

import grpc

NEVER = (grpc.StatusCode.INTERNAL, grpc.StatusCode.UNKNOWN)
TOO_LONG = "metadata size exceeds"  # gRPC's, of an answer whose message does not fit; it ends other calls, too
KEPT = 50  # offences in the report


class Counts:
    """Thread-safe."""

    def __init__(self, late_after):
        self.late_after = late_after
        self.lock = threading.Lock()
        self.codes = collections.defaultdict(collections.Counter)
        self.seconds = collections.defaultdict(list)
        self.offences = []
        self.offence_count = 0

    def add(self, name, answer, requests=(), what="valid"):
        """An answer is an offence if its code is never right, or if it came too late."""
        offence = None
        if answer.code in NEVER or TOO_LONG in answer.details:
            offence = answer.code.name
        elif answer.seconds > self.late_after:
            offence = "LATE"
        with self.lock:
            self.codes[name][answer.code.name] += 1
            self.seconds[name].append(answer.seconds)
            if offence:
                self.offence_count += 1
                if len(self.offences) < KEPT:
                    self.offences.append({"rpc": name, "offence": offence, "details": answer.details[:500],
                                          "seconds": round(answer.seconds, 3), "kind": what,
                                          "requests": [r[:4000].hex() for r in requests]})

    def total(self):
        with self.lock:
            return sum(sum(codes.values()) for codes in self.codes.values())

    def rows(self, names):
        """A row for each RPC."""
        rows = []
        for name in names:
            seconds = sorted(self.seconds[name]) or [0.0]
            codes = self.codes[name]
            rows.append({"rpc": name, "calls": sum(codes.values()), "ok": codes["OK"],
                         "p50_ms": round(1e3 * seconds[len(seconds) // 2], 2),
                         "p99_ms": round(1e3 * seconds[int(0.99 * (len(seconds) - 1))], 2),
                         "max_ms": round(1e3 * seconds[-1], 1), "codes": dict(sorted(codes.items()))})
        return rows


def table(rows):
    """The rows as text."""
    lines = [f"{'RPC':42} {'calls':>7} {'OK':>6} {'p50 ms':>8} {'p99 ms':>8} {'max ms':>8}  other answers"]
    for row in rows:
        others = " ".join(f"{code}:{n}" for code, n in row["codes"].items() if code != "OK")
        lines.append(f"{row['rpc']:42} {row['calls']:>7} {row['ok']:>6} {row['p50_ms']:>8} {row['p99_ms']:>8} "
                     f"{row['max_ms']:>8}  {others}")
    return "\n".join(lines)
