# SPDX-License-Identifier: Apache-2.0
"""Transforms of the plane as q = a p + b conj(p) + c."""
import cmath
import math


class Linear:
    def __init__(self, a, b, c):
        self.a, self.b, self.c = a, b, c

    def __call__(self, p):
        return self.a * p + self.b * p.conjugate() + self.c

    @staticmethod
    def of_rows(rows):
        """From [[xx, xy, x], [yx, yy, y]]."""
        (xx, xy, x), (yx, yy, y) = rows
        along, up = complex(xx, yx), complex(xy, yy)
        return Linear((along - 1j * up) / 2, (along + 1j * up) / 2, complex(x, y))

    def times(self, other):
        """self(other(p))"""
        return Linear(self.a * other.a + self.b * other.b.conjugate(), self.a * other.b + self.b * other.a.conjugate(),
                      self(other.c))

    def inverse(self):
        size = abs(self.a) ** 2 - abs(self.b) ** 2
        result = Linear(self.a.conjugate() / size, -self.b / size, 0)
        result.c = -result(self.c)
        return result

    def turn_and_growth(self):
        """Of one that is not mirrored: degrees, and how much larger it makes areas' sides."""
        return math.degrees(cmath.phase(self.a)), math.sqrt(abs(abs(self.a) ** 2 - abs(self.b) ** 2)) - 1


def solve(matrix, values):
    """A small system, by elimination."""
    rows = [list(row) + [value] for row, value in zip(matrix, values)]
    for i in range(len(rows)):
        pivot = max(range(i, len(rows)), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for k in range(len(rows)):
            if k != i:
                rows[k] = [x - rows[k][i] * y for x, y in zip(rows[k], rows[i])]
    return [row[-1] for row in rows]


def best(points, places, model, mirrored):
    """Least squares. `mirrored`: sheets' y points down, so that what is not mirrored turns the sheet over."""
    if model == "similarity":
        shapes = [lambda p: p if mirrored else p.conjugate(), lambda p: 1]
    else:
        shapes = [lambda p: p, lambda p: p.conjugate(), lambda p: 1]
    rows = [[shape(p) for shape in shapes] for p in points]
    normal = [[sum(complex(row[i]).conjugate() * row[k] for row in rows) for k in range(len(shapes))]
              for i in range(len(shapes))]
    right = [sum(complex(row[i]).conjugate() * q for row, q in zip(rows, places)) for i in range(len(shapes))]
    found = solve(normal, right)
    if model != "similarity":
        return Linear(*found)
    return Linear(found[0], 0, found[1]) if mirrored else Linear(0, found[0], found[1])
