# SPDX-License-Identifier: Apache-2.0
"""Programs, logs, trajectories and pictures."""
import json
import struct
import subprocess
import zlib


def run(*command, **options):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True, **options).stdout


def part_of(log, begin, end, to):
    """The header, and the records of a share of the drive."""
    lines = log.read_text().splitlines(keepends=True)
    first = max(1, int(begin * len(lines)))
    to.write_text("".join(lines[:1] + lines[first : max(first, int(end * len(lines)))]))
    return to


def read_poses(path):
    """(x, y) and yaw."""
    return [(complex(x, y), yaw) for _, x, y, yaw in (map(float, line.split()) for line in path.read_text().splitlines())]


def read_pgm(path):
    """Width, height, and the grey values from the top on."""
    data = path.read_bytes()
    fields = []
    position = 0
    while len(fields) < 4:
        end = position
        while data[end : end + 1] not in (b" ", b"\n"):
            end += 1
        word = data[position:end]
        position = end + 1
        if word.startswith(b"#"):
            position = data.index(b"\n", end) + 1
        elif word:
            fields.append(word)
    if fields[0] != b"P5" or fields[3] != b"255":
        raise ValueError(f"{path}: no grey PGM of 8 bits")
    width, height = int(fields[1]), int(fields[2])
    if len(data) - position != width * height:
        raise ValueError(f"{path}: {len(data) - position} cells of {width} x {height}")
    return width, height, data[position:]


class Raster:
    """A map as Nav2's map_server loads it. Row 0 is the lowest."""

    def __init__(self, yaml):
        values = dict(line.split(":", 1) for line in yaml.read_text().splitlines() if ":" in line)
        self.resolution = float(values["resolution"])
        self.origin = complex(*json.loads(values["origin"])[:2])
        if json.loads(values["origin"])[2] != 0.0 or values["mode"].strip() != "trinary" or int(values["negate"]) != 0:
            raise ValueError(f"{yaml}: turned, negated, or no trinary map")
        occupied, free = float(values["occupied_thresh"]), float(values["free_thresh"])
        self.width, self.height, grey = read_pgm(yaml.parent / values["image"].strip())
        self.grey = b"".join(grey[row * self.width : (row + 1) * self.width] for row in reversed(range(self.height)))
        kinds = bytes(1 if (255 - v) / 255 > occupied else 0 if (255 - v) / 255 < free else 2 for v in range(256))
        self.cells = self.grey.translate(kinds)  # 0 free, 1 occupied, 2 unknown

    def place(self, index):
        """The middle of a cell, m."""
        return self.origin + complex(index % self.width + 0.5, index // self.width + 0.5) * self.resolution

    def index(self, point):
        """The cell around a point, or None."""
        at = (point - self.origin) / self.resolution
        column, row = int(at.real // 1), int(at.imag // 1)
        return row * self.width + column if 0 <= column < self.width and 0 <= row < self.height else None

    def walls(self):
        return [self.place(i) for i, cell in enumerate(self.cells) if cell == 1]


def read_png(path):
    """Width, height, channels, and rows from the top on, of a PNG with 8 bits that is not interlaced."""
    data = path.read_bytes()
    position, packed = 8, b""
    while position < len(data):
        (length,) = struct.unpack(">I", data[position : position + 4])
        kind, body = data[position + 4 : position + 8], data[position + 8 : position + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        position += length + 12
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[color]
    if depth != 8 or interlaced:
        raise ValueError(f"{path}: {depth} bits, interlaced {interlaced}")
    raw = zlib.decompress(packed)
    stride = width * channels
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind = raw[y * (stride + 1)]
        row = bytearray(raw[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        unfilter(kind, row, above, channels)
        rows.append(bytes(row))
        above = row
    return width, height, channels, rows


def unfilter(kind, row, above, channels):
    if kind == 2:
        for i, up in enumerate(above):
            row[i] = (row[i] + up) & 255
    elif kind:
        for i in range(len(row)):
            left = row[i - channels] if i >= channels else 0
            corner = above[i - channels] if i >= channels else 0
            up = above[i]
            if kind == 1:
                guess = left
            elif kind == 3:
                guess = (left + up) // 2
            else:
                whole = left + up - corner
                off = abs(whole - left), abs(whole - up), abs(whole - corner)
                guess = left if off[0] <= off[1] and off[0] <= off[2] else up if off[1] <= off[2] else corner
            row[i] = (row[i] + guess) & 255


def write_png(path, width, channels, rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    header = struct.pack(">IIBBBBB", width, len(rows), 8, {1: 0, 3: 2, 2: 4, 4: 6}[channels], 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
                     chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows))) + chunk(b"IEND", b""))


def mirror_png(path, to):
    """Left is right. Returns the width."""
    width, _, channels, rows = read_png(path)
    write_png(to, width, channels,
              [b"".join(row[i : i + channels] for i in range(len(row) - channels, -1, -channels)) for row in rows])
    return width
