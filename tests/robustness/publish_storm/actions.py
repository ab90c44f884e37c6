# SPDX-License-Identifier: Apache-2.0
"""What goes on while drafts are published."""
import time

from service import hall

from . import calls, drafts, places

COVARIANCE = [0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01]
OPTIMISATION_S = 1  # a server that was killed amid one keeps the site's lease for half a minute


class Actions(drafts.Drafting):
    """Of one interleaving in a place."""

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
