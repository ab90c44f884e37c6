# SPDX-License-Identifier: Apache-2.0
"""Files of every kind that the RPCs take, and what names them."""
import hashlib
import json
import struct
import zlib

# The walls of a building of 14 m x 9 m, m.
WALLS = [((0, 0), (14, 0)), ((14, 0), (14, 9)), ((14, 9), (0, 9)), ((0, 9), (0, 0)), ((5, 0), (5, 3)), ((5, 4), (5, 9)),
         ((5, 4), (7, 4)), ((8, 4), (14, 4)), ((9.5, 4), (9.5, 7.5)), ((2, 0), (2, 2.5)), ((11, 0), (11, 2))]
CELL_M = 0.05


def png(side=48):
    """A grey image with some texture."""
    rows = b"".join(b"\0" + bytes((x * y * 7 + x * 13) % 256 for x in range(side)) for y in range(side))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def building():
    """A map of it as PGM, with 1 m around: white ground between black walls."""
    width, height = 320, 220
    cells = bytearray(254 if 20 <= x < 300 and 20 <= y < 200 else 205 for y in range(height) for x in range(width))
    for (x0, y0), (x1, y1) in WALLS:
        steps = round(max(abs(x1 - x0), abs(y1 - y0)) / CELL_M)
        for i in range(steps + 1):
            x, y = (round((1 + a + (b - a) * i / steps) / CELL_M) for a, b in ((x0, x1), (y0, y1)))
            cells[(height - 1 - y) * width + x] = 0
    return b"P5\n320 220\n255\n" + bytes(cells)


def on_sheet(x, y):
    """The point of the building on its plan, px."""
    return [x / CELL_M, (9 - y) / CELL_M]


def plan():
    """Of the building, as GeoJSON."""
    walls = [{"type": "Feature", "properties": {"kind": "wall"},
              "geometry": {"type": "LineString", "coordinates": [on_sheet(*a), on_sheet(*b)]}} for a, b in WALLS]
    return json.dumps({"type": "FeatureCollection", "frame": "sheet", "metres_per_unit": CELL_M, "features": walls}).encode()


def cloud():
    """Points as float32 x y z."""
    return b"".join(struct.pack("<fff", i * 0.1, i * 0.05, 0.5) for i in range(60))


def sha(data):
    return hashlib.sha256(data).digest()


def ref(data):
    return {"sha256": sha(data), "size_bytes": len(data)}
