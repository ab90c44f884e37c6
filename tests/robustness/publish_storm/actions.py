# SPDX-License-Identifier: Apache-2.0
"""What happens at one time in an interleaving. Each action runs in a thread of its own and has random choices of its own."""
import random
import threading
import time

from google.protobuf import json_format

from service import hall

from . import calls, places, shapes

COVARIANCE = [0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01]
MINE, THEIRS = 1, 2
OPTIMISATION_S = 1  # a server that was killed amid one keeps the site's lease for half a minute
AUTHORS = ("ann", "ben")


class Actions:
    """Of one interleaving in a place. `tally` counts what became of them."""

    def __init__(self, call, place, number, seed, tally):
        self.call, self.place, self.number, self.seed, self.tally = call, place, number, seed, tally

    def rng(self, what):
        return random.Random(f"{self.seed}-{self.number}-{what}")

    def refuse(self, error):
        """What may be refused because the map is deleted meanwhile."""
        if not self.place.deleting:  # else, for example: ALREADY_EXISTS of a session that was created and deleted
            raise calls.Fault(f"refused: {error}") from error

    # Drafts

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
                published = self.call.once("MapEditService.PublishMapDraft", **request)
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

    # What goes on meanwhile

    def import_file(self):
        rng = self.rng("import")
        time.sleep(rng.uniform(0, 0.4))
        picture, keep_edits = places.furnished(self.place.corner, rng), rng.random() < 0.5
        self.place.add_import(picture, keep_edits)
        try:
            self.call.again("MapService.ImportMap",
                            lambda: places.import_requests(self.place.name, picture, keep_edits))
            self.tally.add("imports_that_keep_edits" if keep_edits else "imports_that_end_edits")
        except calls.Refused as error:
            self.refuse(error)

    def restore(self):
        """An older revision becomes the newest one, as if it were imported."""
        rng = self.rng("restore")
        time.sleep(rng.uniform(0, 0.4))
        try:
            revisions = self.call.pages("MapService.ListMapRevisions", "revisions", parent=self.place.name)
            name = rng.choice(revisions).name
            self.place.restored.append(name)
            self.call.sure("MapService.RestoreMapRevision", name=name)
            self.tally.add("restores")
        except calls.Refused as error:
            self.refuse(error)

    def drive(self):
        """A robot records a session into the map."""
        rng = self.rng("drive")
        session_id = f"s{self.number}"
        session = f"{self.place.site}/sessions/{session_id}"
        step = rng.randint(0, 8) if self.place.interleavings > 1 or self.place.begins_with_file else 0
        steps = range(step, step + rng.randint(8, 25))
        payloads = [payload for one in steps for payload in ({"odometry": hall.odometry(one)},
                                                             {"laser_scan": noisy(hall.scan(one), rng)})]
        records = [{"sequence": number, **payload} for number, payload in enumerate(payloads, 1)]
        pauses = [rng.uniform(0, 0.08) for _ in range(0, len(records), 8)]
        x, y = self.place.hall_m[0] + hall.START_M[0] + 0.1 * step, self.place.hall_m[1] + hall.START_M[1]
        entry = {"pose_map_robot": {"pose": {"x": x, "y": y}, "covariance": COVARIANCE}}

        def requests():
            yield {"open": {"session": session}}
            for number, pause in enumerate(pauses):
                time.sleep(pause)
                yield {"batch": {"records": records[8 * number:8 * number + 8]}}

        try:
            self.call.sure("SessionService.CreateSession", parent=self.place.site, session_id=session_id,
                           request_id=session, session={"robot": f"{self.place.site}/robots/r", "map": self.place.name,
                                                        "entry": entry})
            self.place.sessions.append(session)
            self.call.again("IngestService.StreamRecords", requests)
            self.call.sure("SessionService.FinishSession", name=session, last_sequence=len(records))
            self.tally.add("sessions")
        except calls.Refused as error:
            self.refuse(error)

    def optimise(self):
        """Moves the place that joins the map to its neighbour, and has the graph optimised."""
        rng = self.rng("optimise")
        site = self.place.site
        for _ in range(rng.randint(1, 3)):
            time.sleep(rng.uniform(0, 0.15))
            place = {"pose": {"x": self.place.hall_m[0] + 8 + rng.uniform(-0.2, 0.2), "y": self.place.hall_m[1] + 3},
                     "covariance": COVARIANCE}
            anchors = [{"map": self.place.name, "pose_map_place": place},
                       {"map": f"{site}/maps/n", "pose_map_place": {"pose": {"x": 1}, "covariance": COVARIANCE}}]
            try:
                self.call.sure("LinkPointService.UpdateLinkPoint",
                               link_point={"name": f"{site}/linkPoints/d", "anchors": anchors},
                               update_mask={"paths": ["anchors"]})
                self.call.stream("GraphService.OptimizeGraph", [{"site": site}], timeout=OPTIMISATION_S)
                self.tally.add("optimisations")
            except calls.Lost:
                self.tally.add("optimisations_given_up")
            except calls.Refused as error:
                if error.code != "ABORTED":  # the graph keeps changing
                    self.refuse(error)

    def delete(self):
        rng = self.rng("delete")
        time.sleep(rng.uniform(0, 0.6))
        self.place.deleting = True
        lost = []
        while True:
            try:
                self.call.again("MapService.DeleteMap", lambda: [{"name": self.place.name, "force": True}], lost)
                break
            except calls.Refused as error:
                if error.code == "NOT_FOUND" and lost:
                    break  # by the call whose answer was lost
                self.tally.add("deadlocks", error.is_deadlock)
                if error.code != "ABORTED":  # a session came meanwhile
                    raise calls.Fault(f"refused: {error}") from error
        self.place.deleted = True
        self.tally.add("deletes")


def noisy(scan, rng):
    scan["ranges_m"] = [distance + rng.gauss(0, 0.01) for distance in scan["ranges_m"]]
    return scan


def edit_of(message):
    """A stored edit as the dictionary that was sent, for edits that the server has made: patches."""
    patch = json_format.MessageToDict(message.patch, including_default_value_fields=True)
    return {"editId": message.edit_id, "value": json_format.MessageToDict(message)["value"], "patch": patch}
