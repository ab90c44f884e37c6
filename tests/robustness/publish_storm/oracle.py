# SPDX-License-Identifier: Apache-2.0
"""Whether a map is what was sent and acknowledged. Shares no code with the server: shapes are drawn by tests/data/edits."""
from google.protobuf import json_format

from . import calls, places

GREYS = {1: places.UNKNOWN, 2: places.FREE, 3: places.OCCUPIED}
WORDS = {places.UNKNOWN: "unknown", places.FREE: "free", places.OCCUPIED: "occupied"}
MAPPING, IMPORT, EDIT, RESTORED = 1, 2, 3, 4  # sources of revisions
PUBLISHED = 2
NEAR_WALL = 8  # cells: where robots may see something


def fail(text):
    raise calls.Fault(text)


class Oracle:
    """Follows the revisions of one map, each once, in their order."""

    def __init__(self, call, place, tally):
        self.call, self.place, self.tally = call, place, tally
        self.seen = 0  # revisions
        self.version = 0  # the newest edit_version
        self.has_edits = False  # since the last import that ended them
        self.overlay = {}  # what the published edits that count say: {cell: 1 to 3}
        self.picture = None  # of the newest revision that was seen
        self.evidence = None  # below its edits, if that is a file and nothing else
        self.pictures = {}  # of each revision: (picture, overlay, evidence)

    def check(self):
        """All that has come since the last time. Fault if something is not as it must be."""
        if self.place.deleted:
            self.check_deleted()
            return
        revisions = self.call.pages("MapService.ListMapRevisions", "revisions", parent=self.place.name)
        revisions.reverse()
        names = [f"{self.place.name}/revisions/{number}" for number in range(1, len(revisions) + 1)]
        if [revision.name for revision in revisions] != names:
            fail(f"revisions {[revision.name for revision in revisions]}")
        published = self.check_drafts(revisions)
        for revision in revisions[self.seen:]:
            self.follow(revision, published)
        self.seen = len(revisions)
        self.check_evidence()

    # Drafts

    def check_drafts(self, revisions):
        """Of each edit_version its draft, as published."""
        found = self.call.pages("MapEditService.ListMapDrafts", "drafts", parent=self.place.name)
        listed = {draft.name: draft for draft in found}
        edited = [revision for revision in revisions if revision.source == EDIT]
        published = {}
        for draft in self.place.drafts.values():
            if draft.end == "not created":
                continue
            now = listed.pop(draft.name, None) or fail(f"{draft.name} is gone")
            mine = [revision for revision in edited if revision.edit_version == now.edit_version]
            if now.state == PUBLISHED:
                if [revision.name for revision in mine] != [now.revision]:
                    fail(f"{draft.name} is publication {now.edit_version} in {now.revision}, but the revisions of that"
                         f" publication are {[revision.name for revision in mine]}")
                if now.edit_version in published:
                    fail(f"{draft.name} and {published[now.edit_version].name} are one publication")
                published[now.edit_version] = draft
            if draft.answer and draft.answer != now.revision:
                fail(f"{draft.name} was acknowledged as {draft.answer}, but is {now.revision or 'open'}")
            if draft.drawn is None:
                drawn = self.read_draft(draft)
                draft.drawn = drawn if now.state == PUBLISHED else None
        if listed:
            fail(f"nobody has made {sorted(listed)}")
        if len(edited) != len(published):
            fail(f"{len(edited)} revisions of edits, but {len(published)} published drafts")
        return published

    def read_draft(self, draft):
        """Its active edits in their order, with their cells. Every acknowledged one must be there, once, unchanged."""
        stored = self.call.pages("MapEditService.ListMapEdits", "edits", parent=draft.name)
        stored.sort(key=lambda edit: edit.sequence)
        ids = [edit.edit_id for edit in stored]
        if len(set(ids)) != len(ids):
            fail(f"{draft.name} has an edit twice: {ids}")
        if missing := draft.acknowledged - set(ids):
            fail(f"{draft.name} lacks edits that were acknowledged: {sorted(missing)}")
        if refused := draft.refused & set(ids):
            fail(f"{draft.name} has edits that were refused: {sorted(refused)}")
        for author, order in draft.order.items():
            if [edit_id for edit_id in ids if edit_id in order] != order:
                fail(f"{draft.name} has the edits of {author} in another order")
        drawn = []
        for edit in stored:
            sent = draft.sent.get(edit.edit_id)
            if sent is None:
                self.check_settling(draft, edit)
                sent = edit_of(edit)
            elif self.shape_of(edit) != self.shape_of(draft.messages[edit.edit_id]):
                fail(f"{draft.name} has another edit {edit.edit_id}: {edit}")
            if edit.active if edit.edit_id in draft.undone else not edit.active and edit.edit_id not in draft.maybe_undone:
                fail(f"{edit.edit_id} of {draft.name} is {'' if edit.active else 'not '}active")
            if edit.active:
                drawn.append(draft.covered(sent))
        return drawn

    @staticmethod
    def shape_of(edit):
        kind = edit.WhichOneof("shape")
        return kind, getattr(edit, kind), edit.value, edit.author

    @staticmethod
    def check_settling(draft, edit):
        """An edit that the server has made, to settle a conflict by what others say."""
        box = edit.patch.box
        if not any(box == one for one in draft.settled):
            fail(f"nobody has sent edit {edit.edit_id} of {draft.name}")

    # Revisions

    def follow(self, revision, published):
        """Compares the next revision with what must be in it."""
        picture, shown = self.export(revision.name)
        if shown != revision.name:
            fail(f"{revision.name} is exported as {shown}")
        self.tally.add("revisions")
        if revision.source == EDIT:
            self.follow_edit(revision, picture, published)
        elif revision.source == IMPORT:
            self.follow_import(revision, picture)
        elif revision.source == RESTORED:
            self.follow_restored(revision, picture)
        elif revision.source == MAPPING:
            self.evidence = None
        else:
            fail(f"{revision.name} has source {revision.source}")
        if revision.edit_version != (self.version if self.has_edits else 0):
            fail(f"{revision.name} has edit_version {revision.edit_version} after {self.version}")
        self.compare_edits(revision.name, picture)
        self.picture = picture
        self.pictures[revision.name] = (picture, dict(self.overlay), self.evidence)

    def follow_edit(self, revision, picture, published):
        if revision.edit_version != self.version + 1:
            fail(f"{revision.name} is publication {revision.edit_version} after {self.version}")
        draft = published[revision.edit_version]
        self.version, self.has_edits = revision.edit_version, True
        touched = set()
        for covered, value in draft.drawn:
            touched |= covered
            for cell in covered:
                if value:
                    self.overlay[cell] = value
                else:
                    self.overlay.pop(cell, None)
        if self.picture is None or not picture.same_place(self.picture):
            fail(f"{revision.name} has other cells than the revision before")
        before, after = bytearray(self.picture.greys), bytearray(picture.greys)
        for place in filter(None, map(picture.index, touched)):
            before[place] = after[place]
        if before != after:
            fail(f"{revision.name} changes cells that {draft.name} has not edited: {differences(picture, before, after)}")
        if self.evidence:
            self.compare(f"{revision.name} of {draft.name}", picture, self.evidence, self.overlay)

    def follow_import(self, revision, picture):
        """Finds the import that it is."""
        for file, keep_edits in self.place.imports:
            overlay = self.overlay if keep_edits else {}
            if picture.same_place(file) and picture.greys == laid_over(file, overlay):
                self.evidence, self.overlay = file, dict(overlay)
                self.has_edits = self.has_edits and keep_edits
                return
        fail(f"{revision.name} is none of the {len(self.place.imports)} imports with the edits that it must have")

    def follow_restored(self, revision, picture):
        """What an older revision showed. Edits in it are a part of it."""
        older = [self.pictures[name][0] for name in self.place.restored if name in self.pictures]
        if not any(picture.same_place(one) and picture.greys == one.greys for one in older):
            fail(f"{revision.name} is none of {self.place.restored}")
        self.evidence, self.overlay, self.has_edits = picture, {}, False

    def compare_edits(self, name, picture):
        wrong = [cell for cell, value in self.overlay.items()
                 if (place := picture.index(cell)) is not None and picture.greys[place] != GREYS[value]]
        self.tally.add("edited_cells", len(self.overlay))
        if wrong:
            cell = min(wrong)
            fail(f"{name} lacks {len(wrong)} of {len(self.overlay)} edited cells: {cell} is "
                 f"{WORDS.get(picture.greys[picture.index(cell)])} instead of {WORDS[GREYS[self.overlay[cell]]]}")

    @staticmethod
    def compare(name, picture, evidence, overlay):
        """All cells: edits, and what is seen where there are none."""
        if not picture.same_place(evidence):
            fail(f"{name} has other cells than what is below its edits")
        expected = laid_over(evidence, overlay)
        if picture.greys != expected:
            fail(f"{name} is not its evidence with its edits: {differences(picture, expected, picture.greys)}")

    def check_evidence(self):
        """The newest revision is what is below its edits, and they."""
        evidence, name = self.export(self.place.name, without_edits=True)
        if name not in self.pictures:
            return  # robots have mapped on meanwhile
        picture, overlay, file = self.pictures[name]
        self.compare(name, picture, evidence, overlay)
        if file and evidence.greys != file.greys:
            fail(f"{name} without its edits is not the file that was imported")
        self.check_seen(name, evidence)
        self.tally.add("evidence")

    def check_seen(self, name, evidence):
        """No edit has become a part of what is seen: inside the hall there is nothing but imported furniture."""
        if self.place.restored:
            return
        left, bottom = self.place.corner
        furniture = [file for file, _ in self.place.imports]
        for row in range(bottom + NEAR_WALL, bottom + places.HEIGHT - NEAR_WALL):
            start = evidence.index((left + NEAR_WALL, row))
            if start is None:
                continue
            found = evidence.greys.find(places.OCCUPIED, start, start + places.WIDTH - 2 * NEAR_WALL)
            while found >= 0:
                cell = (left + NEAR_WALL + found - start, row)
                if not any(file.greys[file.index(cell)] == places.OCCUPIED for file in furniture):
                    fail(f"{name} without its edits has an obstacle at {cell}, where nobody has seen one")
                found = evidence.greys.find(places.OCCUPIED, found + 1, start + places.WIDTH - 2 * NEAR_WALL)

    def export(self, name, without_edits=False):
        """The picture, and the name of its revision."""
        answers = self.call.again("MapService.ExportMap",
                                  lambda: [{"name": name, "format": places.PGM, "without_edits": without_edits}])
        manifest = answers[0].manifest
        files = [b""] * len(manifest.files)
        for answer in answers[1:]:
            files[answer.chunk.file] += answer.chunk.data
        return (places.read_picture({entry.name: data for entry, data in zip(manifest.files, files)}),
                manifest.revision.name)

    # The end

    def check_deleted(self):
        """Nothing is left of the map."""
        place = self.place
        revisions = [f"{place.name}/revisions/{number}" for number in range(1, self.seen + 2)]
        gone = [("MapService.GetMap", {"name": place.name}), ("MapService.ExportMap", {"name": place.name, "format": 1}),
                ("MapService.ListMapRevisions", {"parent": place.name}),
                ("MapEditService.ListMapDrafts", {"parent": place.name}),
                ("MapEditService.ListContestedEdits", {"parent": place.name})]
        gone += [("MapService.GetMapRevision", {"name": name}) for name in revisions]
        for draft in place.drafts.values():
            gone += [("MapEditService.GetMapDraft", {"name": draft.name}),
                     ("MapEditService.ListMapEdits", {"parent": draft.name}),
                     ("MapEditService.CheckMapDraft", {"name": draft.name}),
                     ("MapEditService.PublishMapDraft", {"name": draft.name, "message": "late"})]
        for name, request in gone:
            try:
                self.call.sure(name, None, **request)
            except calls.Refused as error:
                if error.code == "NOT_FOUND":
                    continue
                fail(f"{error}, of a map that is deleted")
            fail(f"{name} {request} of a map that is deleted has an answer")


def laid_over(picture, overlay):
    greys = bytearray(picture.greys)
    for cell, value in overlay.items():
        place = picture.index(cell)
        if place is not None:
            greys[place] = GREYS[value]
    return bytes(greys)


def differences(picture, expected, found):
    places_of = [place for place, (one, other) in enumerate(zip(expected, found)) if one != other]
    first = places_of[0]
    cell = (first % picture.width + picture.left, first // picture.width + picture.bottom)
    return f"{len(places_of)} cells, the first {cell}: {found[first]} instead of {expected[first]}"


def edit_of(message):
    """A stored edit as the dictionary that was sent, for edits that the server has made: patches."""
    patch = json_format.MessageToDict(message.patch, including_default_value_fields=True)
    return {"editId": message.edit_id, "value": json_format.MessageToDict(message)["value"], "patch": patch}
