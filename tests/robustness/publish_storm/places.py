# SPDX-License-Identifier: Apache-2.0
"""The hall as a map: its files, and which cell is where. Cells are counted in the map's frame: cell (0, 0) begins at its
origin, whatever lattice a draft or a raster has."""
import hashlib

from service import hall

CELL_M = 0.05
MARGIN = 10  # cells around the hall in a file
WIDTH, HEIGHT = round(hall.WIDTH_M / CELL_M), round(hall.HEIGHT_M / CELL_M)
INDOOR, NAV2, PGM = 1, 1, 1
FREE, OCCUPIED, UNKNOWN = 254, 0, 205  # greys


def cell_of(metres):
    """Of a coordinate on the border between two cells."""
    cell = round(metres / CELL_M)
    if abs(cell * CELL_M - metres) > 1e-6:
        raise ValueError(f"{metres} m is not on the lattice of {CELL_M} m")
    return cell


class Picture:
    """A raster's greys, row by row from the lowest, with its lower-left cell in the map's frame."""

    def __init__(self, left, bottom, width, height, greys):
        self.left, self.bottom, self.width, self.height, self.greys = left, bottom, width, height, bytes(greys)

    def index(self, cell):
        """None outside of it."""
        column, row = cell[0] - self.left, cell[1] - self.bottom
        return row * self.width + column if 0 <= column < self.width and 0 <= row < self.height else None

    def same_place(self, other):
        return (self.left, self.bottom, self.width, self.height) == (other.left, other.bottom, other.width, other.height)


def read_picture(files):
    """Of an exported PGM and its YAML."""
    image = next(data for name, data in files.items() if name.endswith(".pgm"))
    text = next(data for name, data in files.items() if name.endswith(".yaml")).decode()
    fields = dict(line.split(":", 1) for line in text.splitlines() if ":" in line)
    x, y, yaw = (float(number) for number in fields["origin"].strip(" []").split(","))
    if float(fields["resolution"]) != CELL_M or yaw != 0:
        raise ValueError(f"an unexpected raster: {text}")
    kind, width, height, largest, rows = _split_pgm(image)
    if kind != b"P5" or largest != 255 or len(rows) != width * height:
        raise ValueError("not a PGM of 8 bits")
    greys = b"".join(rows[row * width:(row + 1) * width] for row in reversed(range(height)))
    return Picture(cell_of(x), cell_of(y), width, height, greys)


def _split_pgm(image):
    fields, at = [], 0
    while len(fields) < 4:
        while image[at:at + 1].isspace():
            at += 1
        end = at
        while not image[end:end + 1].isspace():
            end += 1
        if image[at:at + 1] == b"#":
            at = image.index(b"\n", at)
            continue
        fields.append(image[at:end])
        at = end
    return fields[0], int(fields[1]), int(fields[2]), int(fields[3]), image[at + 1:]


def furnished(corner, rng):
    """A picture of the hall whose lower-left corner is at this cell, with furniture that no other one has. The way that
    robots drive is free."""
    width, height = WIDTH + 2 * MARGIN, HEIGHT + 2 * MARGIN
    greys = bytearray([UNKNOWN]) * (width * height)

    def fill(left, bottom, right, top, grey):
        for row in range(bottom, top):
            greys[row * width + left:row * width + right] = bytes([grey]) * (right - left)

    fill(MARGIN - 1, MARGIN - 1, MARGIN + WIDTH + 1, MARGIN + HEIGHT + 1, OCCUPIED)
    fill(MARGIN, MARGIN, MARGIN + WIDTH, MARGIN + HEIGHT, FREE)
    for _ in range(rng.randint(1, 4)):
        left, bottom = MARGIN + rng.randrange(WIDTH - 12), MARGIN + rng.choice((rng.randrange(20), rng.randrange(90, 108)))
        fill(left, bottom, left + rng.randint(2, 12), bottom + rng.randint(2, 12), OCCUPIED)
    return Picture(corner[0] - MARGIN, corner[1] - MARGIN, width, height, greys)


def import_requests(parent, picture, keep_edits):
    """Of ImportMap."""
    rows = b"".join(picture.greys[row * picture.width:(row + 1) * picture.width] for row in reversed(range(picture.height)))
    files = {"hall.yaml": (f"image: hall.pgm\nresolution: {CELL_M}\norigin: [{picture.left * CELL_M:.2f}, "
                           f"{picture.bottom * CELL_M:.2f}, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
                           "free_thresh: 0.196\n").encode(),
             "hall.pgm": f"P5\n{picture.width} {picture.height}\n255\n".encode() + rows}
    entries = [{"name": name, "size_bytes": len(data), "sha256": hashlib.sha256(data).digest()}
               for name, data in files.items()]
    yield {"manifest": {"parent": parent, "dialect": NAV2, "files": entries, "keep_edits": keep_edits}}
    for number, data in enumerate(files.values()):
        yield {"chunk": {"file": number, "data": data}}
