# SPDX-License-Identifier: Apache-2.0
"""What was sent and what was acknowledged, beside the server: what must hold follows from it."""
import threading

from google.protobuf import json_format

from . import places, shapes

HOT_SPOTS = 4


class Draft:
    """One draft. `sent`: all edits that may be in it; `acknowledged`: that must be; `refused`: that must not."""

    def __init__(self, parent, draft_id):
        self.name = f"{parent}/drafts/{draft_id}"
        self.draft_id = draft_id
        self.origin = (0, 0)  # of its lattice: a cell of the map's frame
        self.sent, self.messages = {}, {}
        self.order = {}  # of each author the edits that were acknowledged
        self.acknowledged, self.refused, self.undone = set(), set(), set()
        self.maybe_undone = set()
        self.settled = []  # boxes where it took what others say
        self.answer = None  # to publishing it: the revision's name
        self.end = ""  # why it was not published
        self.drawn = None  # its active edits once it is published: [(cells, value)]

    def send(self, edit, message):
        json_format.ParseDict(edit, message)
        self.sent[edit["editId"]], self.messages[edit["editId"]] = edit, message

    def covered(self, edit):
        """Its cells in the map's frame, and what they become: 0 for clear."""
        found, value = shapes.covered(edit)
        return {(column + self.origin[0], row + self.origin[1]) for column, row in found}, value


class Place:
    """One map on a site of its own, from its creation to its deletion."""

    def __init__(self, site, rng, map_id="m"):
        self.site, self.map_id = f"sites/{site}", map_id
        self.name = f"{self.site}/maps/{map_id}"
        self.begins_with_file = rng.random() < 0.6
        # Robots begin a map at its origin. A file may lie on the same cells as what they map later, or not.
        self.hall_m = (0.5, 0.5) if self.begins_with_file else (-2.0, -2.5)
        if self.begins_with_file and rng.random() < 0.3:
            self.hall_m = (0.8, 0.6)
        self.corner = tuple(places.cell_of(metres) for metres in self.hall_m)
        self.spots = [(self.corner[0] + rng.randrange(25, places.WIDTH - 25),
                       self.corner[1] + rng.randrange(25, places.HEIGHT - 25)) for _ in range(HOT_SPOTS)]
        self.lock = threading.Lock()
        self.drafts = {}
        self.imports = []  # (picture, keep_edits), also those whose answers were lost
        self.restored = []  # names of older revisions, also where the answers were lost
        self.sessions = []
        self.interleavings = 0
        self.deleted = False  # acknowledged
        self.deleting = False

    def add_draft(self, draft_id):
        with self.lock:
            return self.drafts.setdefault(draft_id, Draft(self.name, draft_id))

    def forget_draft(self, draft):
        with self.lock:
            del self.drafts[draft.draft_id]

    def add_import(self, picture, keep_edits):
        with self.lock:
            self.imports.append((picture, keep_edits))
