# SPDX-License-Identifier: Apache-2.0
"""Drafts in an interleaving: drawn by one or two authors, put over what others have published, and published."""
import random
import threading
import time

from . import calls, places, shapes

MINE, THEIRS = 1, 2
AUTHORS = ("ann", "ben")


class Drafting:
    """In a place. `tally` counts what became of it. Each action runs in a thread of its own and has random choices of its
    own."""

    def __init__(self, call, place, number, seed, tally):
        self.call, self.place, self.number, self.seed, self.tally = call, place, number, seed, tally

    def rng(self, what):
        return random.Random(f"{self.seed}-{self.number}-{what}")

    def refuse(self, error):
        """What may be refused because the map is deleted meanwhile."""
        if not self.place.deleting:  # else, for example: ALREADY_EXISTS of a session that was created and deleted
            raise calls.Fault(f"refused: {error}") from error

    def create(self, draft_id, attempt):
        """None if the map is gone."""
        draft = self.place.add_draft(draft_id)
        try:
            created = self.call.sure("MapEditService.CreateMapDraft", parent=self.place.name, draft_id=draft_id,
                                     request_id=f"{self.number}-{draft_id}-{attempt}").draft
        except calls.Refused as error:
            self.refuse(error)
            draft.end = "not created"
            return None
        pose = created.lattice.pose_map_lattice
        draft.origin = (places.cell_of(pose.x), places.cell_of(pose.y))
        return draft

    def throw_away(self, draft):
        """Whether it was deleted. Another one may have its name then."""
        lost = []
        try:
            self.call.again("MapEditService.DeleteMapDraft", lambda: [{"name": draft.name}], lost)
        except calls.Refused as error:
            if error.code != "NOT_FOUND" or not lost:
                self.refuse(error)
                return False
        self.tally.add("drafts_thrown_away")
        self.place.forget_draft(draft)
        return True

    def append(self, draft, edits):
        """Whether it was acknowledged."""
        request = self.call.api.methods["MapEditService.AppendMapEdits"].request(name=draft.name)
        for edit in edits:
            draft.send(edit, request.edits.add())
        ids = [edit["editId"] for edit in edits]
        lost = []
        try:
            self.call.again("MapEditService.AppendMapEdits", lambda: [request], lost)
        except calls.Refused as error:
            # Published or deleted meanwhile, or its lattice is not the map's any more.
            if error.code not in ("FAILED_PRECONDITION", "NOT_FOUND"):
                raise calls.Fault(f"refused: {error}") from error
            if not lost:
                draft.refused.update(ids)
            self.tally.add("appends_refused")
            return False
        finally:
            self.tally.add("appends_sent_again", len(lost))
        draft.acknowledged.update(ids)
        draft.order.setdefault(edits[0]["author"], []).extend(ids)
        self.tally.add("edits_acknowledged", len(ids))
        return True

    def undo(self, draft, edit_id, author):
        draft.maybe_undone.add(edit_id)
        try:
            self.call.sure("MapEditService.SetMapEditsActive", name=draft.name, edit_ids=[edit_id], active=False,
                           author=author)
            draft.undone.add(edit_id)
        except calls.Refused as error:
            if error.code not in ("FAILED_PRECONDITION", "NOT_FOUND"):
                raise calls.Fault(f"refused: {error}") from error

    def draw(self, draft, author, rng, count):
        pen = shapes.Pen(rng, draft.origin, self.place.spots)
        edits = pen.edits(author, count)
        while edits:
            size = rng.randint(1, 3)
            if not self.append(draft, edits[:size]):
                return
            edits = edits[size:]
            time.sleep(rng.choice((0, 0, rng.uniform(0, 0.05))))
        if rng.random() < 0.25:
            self.undo(draft, rng.choice(sorted(draft.order[author])), author)

    def repeat(self, draft, of):
        """Says what another draft says."""
        edits = []
        for number, edit in enumerate(list(of.sent.values())[:20]):
            edits.append({**edit, "editId": f"{draft.draft_id}-{number}", "author": "ben"})
        if edits and draft.origin == of.origin:
            self.append(draft, edits)

    def publish_draft(self, draft_id, repeated=None):
        """Draws a draft with one or two authors, and publishes it."""
        rng = self.rng(draft_id)
        draft = self.create(draft_id, 1)
        if draft and rng.random() < 0.12:
            self.draw(draft, AUTHORS[0], rng, rng.randint(1, 3))
            draft = self.create(draft_id, 2) if self.throw_away(draft) else None
        if draft is None:
            return
        if repeated in self.place.drafts:
            self.repeat(draft, self.place.drafts[repeated])
        else:
            self.draw(draft, AUTHORS[0], rng, rng.randint(1, 4))
        other = threading.Thread(target=self.tally.guard, args=(self.number, self.draw, draft, AUTHORS[1],
                                                                self.rng(draft_id + "-ben"), rng.randint(1, 5)))
        with_other = rng.random() < 0.5
        if with_other:
            other.start()
        if rng.random() < 0.5 and with_other:
            other.join()
        time.sleep(rng.choice((0, rng.uniform(0, 0.15))))
        self.publish(draft, rng)
        if with_other:
            other.join()

    def publish(self, draft, rng):
        """Until it is known what became of it."""
        request = {"name": draft.name, "message": f"{draft.draft_id} of {self.number}", "confirm_warnings": True}
        while True:
            self.call.publishing.set()
            try:
                # Now and then the caller does not wait for the answer.
                patience = rng.uniform(0, 0.3) if rng.random() < 0.2 else calls.CALL_S
                published = self.call.stream("MapEditService.PublishMapDraft", [request], timeout=patience)[0]
                self.tally.add("publishes_acknowledged")
                draft.answer = published.revision.name
                return
            except calls.Lost:
                self.tally.add("publishes_lost")
                self.call.up.wait()
                if self.look_up(draft, request, rng):
                    return
            except calls.Refused as error:
                if error.is_deadlock:
                    self.tally.add("deadlocks")
                    continue
                if error.code == "ABORTED" and "RebaseMapDraft" in error.details and self.rebase(draft, rng):
                    continue
                self.tally.add("publishes_refused")
                self.tally.add(f"publishes_refused_{error.code}")
                draft.end = str(error)
                return

    def look_up(self, draft, request, rng):
        """After a lost answer: whether it is published, or gone."""
        try:
            found = self.call.sure("MapEditService.GetMapDraft", name=draft.name).draft
        except calls.Refused as error:
            self.refuse(error)
            draft.end = "deleted"
            return True
        if not found.revision:
            return False
        self.tally.add("publishes_found_after_a_lost_answer")
        draft.answer = found.revision
        if rng.random() < 0.5:
            try:
                again = self.call.sure("MapEditService.PublishMapDraft", **request)
                if again.revision.name != found.revision:
                    raise calls.Fault(f"{draft.name} is {found.revision}, and published again {again.revision.name}")
            except calls.Refused as error:
                self.refuse(error)
        return True

    def rebase(self, draft, rng):
        """Settles all conflicts in one way or the other, or gives up."""
        if rng.random() < 0.15:
            return False
        self.tally.add("rebases")
        try:
            check = self.call.sure("MapEditService.CheckMapDraft", name=draft.name)
            resolutions = [{"box": conflict.box, "choice": rng.choice((MINE, THEIRS))} for conflict in check.conflicts]
            # It counts even if the answer is lost.
            draft.settled += [one["box"] for one in resolutions if one["choice"] == THEIRS]
            self.call.sure("MapEditService.RebaseMapDraft", name=draft.name, edit_version=check.edit_version,
                           author="ann", resolutions=resolutions)
        except calls.Refused as error:
            # ABORTED: others have published again. FAILED_PRECONDITION: on other cells, which no rebase settles.
            return error.code == "ABORTED"
        return True
