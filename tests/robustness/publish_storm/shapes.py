# SPDX-License-Identifier: Apache-2.0
"""Random edits, small enough to be drawn cell by cell, near a few places where they often meet."""
import sys
import uuid

from service.system import ROOT

sys.path.append(str(ROOT / "tests/data/edits"))
import cells  # noqa: E402  # pylint: disable=wrong-import-position

VALUES = (("VALUE_OCCUPIED", 35), ("VALUE_FREE", 30), ("VALUE_UNKNOWN", 20), ("VALUE_CLEAR", 15))
UNITS = 256  # of a cell


def covered(edit):
    """Its cells on its lattice, and what they become: 1 unknown, 2 free, 3 occupied, 0 clear."""
    return cells.covered(edit), cells.VALUES[edit["value"]]


class Pen:
    """Draws on a lattice whose cell (0, 0) is `origin` (column, row) in the map's frame. `places`: cells of the frame."""

    def __init__(self, rng, origin, places):
        self.rng, self.origin, self.places = rng, origin, places
        self.at = origin

    def edit(self, author):
        """A MapEdit, as in JSON, that has cells."""
        while True:
            edit = self._any(author)
            if cells.covered(edit):
                return edit

    def _any(self, author):
        rng = self.rng
        kind = rng.choice(("brush", "brush", "line", "polygon", "polygon", "patch"))
        value = rng.choices([name for name, _ in VALUES], [weight for _, weight in VALUES])[0]
        column, row = rng.choice(self.places)
        self.at = (column - self.origin[0] + rng.randint(-6, 6), row - self.origin[1] + rng.randint(-6, 6))
        return {"editId": str(uuid.UUID(int=rng.getrandbits(128), version=4)), "author": author, "value": value,
                kind: getattr(self, "_" + kind)()}

    def edits(self, author, count):
        return [self.edit(author) for _ in range(count)]

    def _near(self, reach):
        """A point at most so many cells away, now and then exactly on a corner or a centre."""
        point = {}
        for axis, cell in zip("xy", self.at):
            within = self.rng.choice((0, 128, self.rng.randrange(UNITS)))
            point[axis] = (cell + self.rng.randint(-reach, reach)) * UNITS + within
        return point

    def _brush(self):
        return {"points": [self._near(8) for _ in range(self.rng.randint(1, 3))], "radius": self.rng.randrange(4 * UNITS)}

    def _line(self):
        return {"points": [self._near(14) for _ in range(self.rng.randint(1, 3))]}

    def _polygon(self):
        if self.rng.random() < 0.5:
            return {"rings": [{"points": [self._near(9) for _ in range(3)]}]}
        low, high = self._near(3), self._near(3)
        left, right = low["x"] - 2 * UNITS, max(low["x"], high["x"]) + 2 * UNITS
        bottom, top = low["y"] - 2 * UNITS, max(low["y"], high["y"]) + 2 * UNITS

        def ring(inset):
            return {"points": [{"x": x, "y": y} for x, y in ((left + inset, bottom + inset), (right - inset, bottom + inset),
                                                             (right - inset, top - inset), (left + inset, top - inset))]}

        return {"rings": [ring(0)] + ([ring(UNITS)] if self.rng.random() < 0.3 else [])}

    def _patch(self):
        width, height = self.rng.randint(1, 10), self.rng.randint(1, 10)
        runs, left = [], width * height
        while left > 0:
            runs.append(min(left, self.rng.randint(0 if not runs else 1, 12)))
            left -= runs[-1]
        if len(runs) == 1:
            runs = [0, width * height]  # it takes something
        return {"box": {"firstColumn": self.at[0], "firstRow": self.at[1], "width": width, "height": height}, "runs": runs}
