# SPDX-License-Identifier: Apache-2.0
"""Valid calls of every RPC on a site of their own, which becomes the deep state that malformed calls are made on."""
import random
import time

import grpc

from service.hall import START_S, odometry, scan

from .inputs import CELL_M, building, cloud, on_sheet, plan, png, ref, sha

INDOOR, DOOR, PGM, NAV2 = 1, 1, 1, 1
FREE, OCCUPIED, CLEAR, KEEP, MINE = 2, 3, 4, 1, 1  # of edits
COVARIANCE = [0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01]
WORLD = {"pose": {"x": 1.0, "y": 0.5, "yaw": 0.1}, "covariance": COVARIANCE}
TIMEOUT_S = 60
KEEP_OUT, SPEED_LIMIT, ROOM = 1, 2, 5  # kinds of areas
AREA_FORMATS = (1, 2, 3)  # GeoJSON, and masks for Nav2
DONE_STATES = (3, 4)  # of a session: MAPPED, FAILED
CAUSE_OPTIMIZED = 7  # of a version of the graph


class TourError(Exception):
    """A valid call failed."""


class Tour:
    """One site with everything in it. `templates`: of each RPC the requests that succeeded, as lists of messages."""

    def __init__(self, api, counts, site_id):
        self.api, self.counts = api, counts
        self.site = f"sites/{site_id}"
        self.templates = {}

    def ok(self, name, *requests, enough=64):
        """Makes a call that must succeed; its responses."""
        method = self.api.methods[name]
        messages = [method.request(**request) for request in requests]
        answer = self.api.call(method, [m.SerializeToString() for m in messages], timeout=TIMEOUT_S, enough=enough)
        self.counts.add(name, answer)
        if answer.code != grpc.StatusCode.OK:
            raise TourError(f"{name} {messages[0]}: {answer.code.name} {answer.details}")
        self.templates.setdefault(name, []).append(messages)
        return [method.response.FromString(r) for r in answer.responses]

    def one(self, name, *requests):
        return self.ok(name, *requests)[0]

    def whole(self, closures):
        """Every RPC at least once."""
        self.sites_and_robots()
        self.maps()
        self.areas()
        first, second = self.drive("one"), self.drive("two")
        self.blobs()
        self.link_points()
        self.await_mapped(first)
        self.await_mapped(second)
        self.sessions(first)
        self.graph()
        self.rearrange(second)
        self.prior_maps()
        self.map_edits()
        self.localize()
        self.closures(closures)

    def sites_and_robots(self):
        site, site_id = self.site, self.site.split("/")[1]
        self.ok("SiteService.CreateSite", {"site_id": site_id, "site": {"display_name": "Fuzzed"}, "request_id": site_id})
        self.ok("SiteService.GetSite", {"name": site})
        self.ok("SiteService.ListSites", {"page_size": 5})
        self.ok("SiteService.UpdateSite", {"site": {"name": site, "display_name": "F"},
                                           "update_mask": {"paths": ["display_name"]}})
        self.ok("ServerService.GetServerStatus", {})
        for robot in ("r", "spare"):
            self.ok("RobotService.CreateRobot", {"parent": site, "robot_id": robot, "robot": {"display_name": robot}})
        self.ok("RobotService.GetRobot", {"name": f"{site}/robots/r"})
        self.ok("RobotService.ListRobots", {"parent": site})
        self.ok("RobotService.DeleteRobot", {"name": f"{site}/robots/spare"})
        self.ok("SiteService.ListAuditEntries", {"parent": site})
        self.ok("SiteService.CreateSite", {"site_id": site_id + "-gone", "site": {"display_name": "Gone"}})
        self.ok("SiteService.DeleteSite", {"name": site + "-gone"})

    def maps(self):
        site = self.site
        for name in ("a", "b", "c", "spare"):
            self.ok("MapService.CreateMap", {"parent": site, "map_id": name, "request_id": f"map-{name}",
                                             "map": {"display_name": name, "environment": INDOOR}})
        self.ok("MapService.GetMap", {"name": f"{site}/maps/a"})
        self.ok("MapService.ListMaps", {"parent": site, "page_size": 2})
        corners = [{"x": 0, "y": 0}, {"x": 9, "y": 0}, {"x": 9, "y": 6}]
        self.ok("MapService.UpdateMap", {"map": {"name": f"{site}/maps/a", "outline": {"corners": corners}},
                                         "update_mask": {"paths": ["outline"]}})
        self.ok("MapService.DeleteMap", {"name": f"{site}/maps/spare"})
        files = {"m.yaml": b"image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
                           b"free_thresh: 0.196\n",
                 "m.pgm": b"P5\n40 30\n255\n" + bytes(254 if 0 < i % 40 < 39 else 0 for i in range(1200))}
        entries = [{"name": n, "size_bytes": len(d), "sha256": sha(d)} for n, d in files.items()]
        chunks = [{"chunk": {"file": i, "data": d}} for i, d in enumerate(files.values())]
        imported = self.one("MapService.ImportMap", {"manifest": {"parent": f"{site}/maps/b", "dialect": NAV2,
                                                                  "files": entries}}, *chunks)
        self.ok("MapService.GetMapRevision", {"name": imported.revision.name})
        manifest = self.one("RasterService.GetRasterManifest", {"name": imported.revision.name})
        self.ok("RasterService.ReadTiles", {"parent": site, "sha256": [manifest.levels[0].tiles[0].sha256]})
        self.ok("RasterService.ListRasterThumbnails", {"parent": site, "page_size": 3})
        self.ok("MapService.TagMapRevision", {"name": imported.revision.name, "tag": "as imported"})
        self.ok("MapService.ListMapRevisions", {"parent": f"{site}/maps/b"})
        self.ok("MapService.ExportMap", {"name": f"{site}/maps/b", "format": PGM})
        self.versions(imported.revision.name, files)

    def versions(self, first, files):
        """Aliases of revisions of the map "b", and a second revision to compare with the first."""
        parent = f"{self.site}/maps/b"
        files = {**files, "m.pgm": b"P5\n40 30\n255\n" + bytes(254 if 0 < i % 40 < 20 else 0 for i in range(1200))}
        entries = [{"name": n, "size_bytes": len(d), "sha256": sha(d)} for n, d in files.items()]
        chunks = [{"chunk": {"file": i, "data": d}} for i, d in enumerate(files.values())]
        second = self.one("MapService.ImportMap", {"manifest": {"parent": parent, "dialect": NAV2, "files": entries}},
                          *chunks).revision.name
        stable = {"name": f"{parent}/aliases/stable"}
        self.ok("MapService.SetMapAlias", {"alias": {**stable, "revision": first}})
        moved = self.one("MapService.SetMapAlias", {"alias": {**stable, "revision": second}}).alias
        self.ok("MapService.RollBackMapAlias", {**stable, "etag": moved.etag})
        self.ok("MapService.ListMapAliases", {"parent": parent})
        self.ok("MapService.GetMapRevision", stable)
        self.ok("MapService.DiffMapRevisions", {"base": stable["name"], "revision": second, "with_picture": True,
                                                "with_geojson": True})
        self.ok("MapService.RestoreMapRevision", stable)
        self.ok("MapService.SetMapAlias", {"alias": {"name": f"{parent}/aliases/spare", "revision": second}})
        self.ok("MapService.DeleteMapAlias", {"name": f"{parent}/aliases/spare"})

    def areas(self):
        """Of the map "b", which has a revision."""
        parent = f"{self.site}/maps/b"

        def outline(x, y):
            return {"corners": [{"x": x, "y": y}, {"x": x + 0.5, "y": y}, {"x": x, "y": y + 0.5}]}

        for name, kind in (("stop", KEEP_OUT), ("slow", SPEED_LIMIT), ("spare", ROOM)):
            area = {"display_name": name, "kind": kind, "outline": outline(0.1, 0.1), "robot_types": ["cleaner"],
                    "speed_limit_mps": 0.3 if kind == SPEED_LIMIT else 0, "valid_from": {"seconds": START_S}}
            self.ok("MapAreaService.CreateMapArea", {"parent": parent, "area_id": name, "area": area,
                                                     "request_id": f"area-{name}"})
        self.ok("MapAreaService.GetMapArea", {"name": f"{parent}/areas/stop"})
        self.ok("MapAreaService.ListMapAreas", {"parent": parent, "page_size": 2})
        self.ok("MapAreaService.UpdateMapArea", {"area": {"name": f"{parent}/areas/stop", "outline": outline(0.2, 0.3)},
                                                 "update_mask": {"paths": ["outline"]}})
        self.ok("MapAreaService.DeleteMapArea", {"name": f"{parent}/areas/spare"})
        for area_format in AREA_FORMATS:
            self.ok("MapAreaService.ExportMapAreas", {"parent": parent, "format": area_format, "robot_type": "cleaner"})

    def drive(self, session_id, into="a"):
        """A finished session in a map: the first records by single calls, the others by a stream."""
        session = f"{self.site}/sessions/{session_id}"
        self.ok("SessionService.CreateSession",
                {"parent": self.site, "session_id": session_id, "request_id": session_id,
                 "session": {"robot": f"{self.site}/robots/r", "map": f"{self.site}/maps/{into}",
                             "entry": {"pose_map_robot": {"pose": {"x": 0}, "covariance": COVARIANCE}}}})
        image, points = png(), cloud()
        self.ok("IngestService.SubmitOdometry", {"session": session, "sequence": 1, "odometry": odometry(0)})
        self.ok("IngestService.SubmitScan", {"session": session, "sequence": 2, "laser_scan": scan(0)})
        self.ok("IngestService.SubmitImage", {"session": session, "sequence": 3, "data": image, "image":
                                              {"time": {"seconds": START_S}, "camera": 1, "encoding": 1,
                                               "content": ref(image)}})
        self.ok("IngestService.SubmitPointCloud", {"session": session, "sequence": 4, "data": points, "point_cloud":
                                                   {"time": {"seconds": START_S}, "encoding": 2,
                                                    "content": ref(points)}})
        records, payloads = [], [p for step in range(1, 13) for p in ({"odometry": odometry(step)},
                                                                      {"laser_scan": scan(step)})]
        payloads.append({"door_report": {"time": {"seconds": START_S + 13}, "kind": 1, "width_m": 0.9,
                                         "door_time": {"seconds": START_S + 13}, "pose_odom_door": {"x": 1.2},
                                         "pose_odom_gap": {"x": 2.2}}})
        for sequence, payload in enumerate(payloads, 5):
            records.append({"sequence": sequence, **payload})
        report = {"map": f"{self.site}/maps/{into}", "pose_map_robot": WORLD, "time": {"seconds": START_S}}
        blob = b"x" * 100 + session.encode()
        self.ok("IngestService.StreamRecords", {"open": {"session": session}},
                {"blob_chunk": {"blob": ref(blob), "data": blob}}, {"batch": {"records": records[:20]}},
                {"pose_report": report}, {"batch": {"records": records[20:]}})
        self.ok("SessionService.FinishSession", {"name": session, "last_sequence": len(records) + 4})
        return session

    def blobs(self):
        self.ok("IngestService.DownloadBlob", {"parent": self.site, "sha256": sha(png())})

    def link_points(self):
        site = self.site

        def anchor(name, x):
            return {"map": f"{site}/maps/{name}", "pose_map_place": {"pose": {"x": x}, "covariance": COVARIANCE}}

        for name, anchors in (("ab", [anchor("a", 5)]), ("bc", [anchor("b", 9), anchor("c", 1)]), ("spare", [anchor("c", 4)])):
            self.ok("LinkPointService.CreateLinkPoint", {"parent": site, "link_point_id": name, "request_id": "l" + name,
                                                         "link_point": {"kind": DOOR, "anchors": anchors}})
        self.ok("LinkPointService.AddLinkPointAnchor", {"name": f"{site}/linkPoints/ab", "anchor": anchor("b", 0.5)})
        self.ok("LinkPointService.GetLinkPoint", {"name": f"{site}/linkPoints/ab"})
        self.ok("LinkPointService.ListLinkPoints", {"parent": site, "page_size": 1})
        self.ok("LinkPointService.UpdateLinkPoint", {"link_point": {"name": f"{site}/linkPoints/ab", "tag": "t"},
                                                     "update_mask": {"paths": ["tag"]}})
        self.ok("LinkPointService.SuspendLinkPoint", {"name": f"{site}/linkPoints/bc"})
        self.ok("LinkPointService.ResumeLinkPoint", {"name": f"{site}/linkPoints/bc"})
        self.ok("LinkPointService.DeleteLinkPoint", {"name": f"{site}/linkPoints/spare"})
        pose = {"map": f"{site}/maps/a", "pose_map_robot": WORLD}
        for around in ({"pose_in_map": pose}, {"point_world": {"x": 1}}, {"pose_world": WORLD},
                       {"polygon_world": {"corners": [{"x": -50, "y": -50}, {"x": 50, "y": -50}, {"x": 0, "y": 50}]}}):
            self.ok("LinkPointService.FindLinkPoints", {"parent": site, **around})
        image = png(32)
        self.ok("LinkPointService.AttachEvidence",
                {"manifest": {"parent": f"{site}/linkPoints/ab", "evidence":
                              {"map": f"{site}/maps/a", "image": {"time": {"seconds": START_S}, "camera": 1,
                                                                  "encoding": 1, "content": ref(image)}}}},
                {"chunk": {"blob": ref(image), "data": image}})

    def await_mapped(self, session):
        for _ in range(600):
            found = self.one("SessionService.GetSession", {"name": session}).session
            if found.state in DONE_STATES:
                return
            time.sleep(0.1)
        raise TourError(f"{session} is not mapped after a minute")

    def await_verdict(self, session):
        for _ in range(600):
            verdicts = self.one("SessionService.ListDoorVerdicts", {"parent": session}).verdicts
            if verdicts:
                return verdicts[0]
            time.sleep(0.1)
        raise TourError(f"the door of {session} is not judged after a minute")

    def sessions(self, session):
        site = self.site
        self.ok("SessionService.ListSessions", {"parent": site})
        self.ok("SessionService.ExportTrajectory", {"name": session})
        self.ok("SessionService.GetDoorImages", {"name": self.await_verdict(session).name})
        self.ok("SessionService.CreateSession", {"parent": site, "session_id": "spare",
                                                 "session": {"robot": f"{site}/robots/r", "map": f"{site}/maps/c"}})
        self.ok("SessionService.DeleteSession", {"name": f"{site}/sessions/spare"})

    def graph(self):
        site, here = self.site, {"map": f"{self.site}/maps/a", "pose_map_robot": WORLD}
        self.ok("GraphService.GetGraph", {"site": site})
        self.ok("GraphService.ListGraphVersions", {"parent": site, "page_size": 3})
        self.ok("GraphService.OptimizeGraph", {"site": site})
        self.graph_changes()
        versions = self.one("GraphService.ListGraphVersions", {"parent": site, "page_size": 1000}).graph_versions
        optimised = next(version for version in versions if version.cause == CAUSE_OPTIMIZED)
        self.ok("GraphService.ListPlacedMaps", {"parent": site, "graph_version": optimised.graph_version})
        self.ok("GraphService.GetGlobalPose", {"map_pose": here})
        self.ok("GraphService.GetGlobalPose", {"robot": f"{site}/robots/r"})
        self.ok("GraphService.WatchGlobalPoses", {"parent": site, "rate_hz": 20}, enough=1)
        self.ok("WatchService.WatchSite", {"parent": site, "rate_hz": 20, "view": 2}, enough=1)
        self.ok("GraphService.TransformPoses", {"source_map": f"{site}/maps/a", "target_map": f"{site}/maps/c",
                                                "poses": [WORLD]})
        self.ok("GraphService.FindRoutes", {"start_map": f"{site}/maps/a", "pose_map_start": {"x": 1},
                                            "goal_map": f"{site}/maps/c", "pose_map_goal": {"x": 2}, "max_routes": 3,
                                            "with_geojson": True})
        points = [{"map": f"{site}/maps/a", "x": x, "y": y, "latitude": 49 + y / 111_320, "longitude": 8 + x / 73_034}
                  for x, y in ((0, 0), (30, 0), (0, 30))]
        self.ok("GraphService.SetGeoreference", {"site": site, "georeference": {"control_points": points}})
        self.ok("GraphService.GetGeoreference", {"site": site})
        self.ok("GraphService.ExportGraph", {"site": site})

    def graph_changes(self):
        """Each kind of change, looked at first, then made."""
        site = self.site
        place = {"pose": {"x": 6, "y": 3}, "covariance": COVARIANCE}
        anchors = [{"map": f"{site}/maps/{name}", "pose_map_place": place} for name in ("a", "c")]
        moved = self.one("LinkPointService.GetLinkPoint", {"name": f"{site}/linkPoints/ab"}).link_point
        moved.anchors[1].pose_map_place.pose.x += 0.1
        changes = [{"created": {"name": f"{site}/linkPoints/ac", "kind": DOOR, "anchors": anchors}}, {"updated": moved},
                   {"updated": {"name": f"{site}/linkPoints/bc", "difficulty": 2}, "update_mask": {"paths": ["difficulty"]}},
                   {"suspended": f"{site}/linkPoints/ac"}, {"resumed": f"{site}/linkPoints/ac"},
                   {"deleted": f"{site}/linkPoints/ac"}]
        self.ok("GraphService.PreviewGraph", {"site": site, "changes": changes})
        self.ok("GraphService.ChangeGraph", {"site": site, "changes": changes})
        self.ok("GraphService.AlignMaps", {"map_a": f"{site}/maps/a", "map_b": f"{site}/maps/b", "pose_a_b": {"x": 5},
                                           "radius_m": 1, "yaw_range_rad": 0.2})

    def rearrange(self, session):
        site = self.site
        merged = self.one("MapService.MergeMaps", {"name": f"{site}/maps/b", "merged_map": f"{site}/maps/c",
                                                   "pose_name_merged": {"x": 8}})
        self.ok("MapService.UndoRearrangement", {"name": merged.rearrangement.name})
        self.ok("MapService.SplitMap", {"name": f"{site}/maps/a", "sessions": [session], "map_id": "split"})
        self.ok("MapService.ListRearrangements", {"parent": site})

    def prior_maps(self):
        """On a site of their own, whose only map is the building."""
        site = self.site + "-plan"
        self.ok("SiteService.CreateSite", {"site_id": site.split("/")[1], "site": {"display_name": "Plan"}})
        self.ok("MapService.CreateMap", {"parent": site, "map_id": "m", "map": {"display_name": "m", "environment": INDOOR}})
        files = {"m.yaml": f"image: m.pgm\nresolution: {CELL_M}\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
                           "free_thresh: 0.196\n".encode(), "m.pgm": building()}
        entries = [{"name": n, "size_bytes": len(d), "sha256": sha(d)} for n, d in files.items()]
        chunks = [{"chunk": {"file": i, "data": d}} for i, d in enumerate(files.values())]
        self.ok("MapService.ImportMap", {"manifest": {"parent": f"{site}/maps/m", "dialect": NAV2, "files": entries}}, *chunks)
        for name in ("plan", "spare"):
            self.ok("PriorMapService.ImportPriorMap",
                    {"manifest": {"parent": site, "prior_map_id": name, "display_name": name, "request_id": name,
                                  "file": {"name": "plan.geojson", "size_bytes": len(plan()), "sha256": sha(plan())}}},
                    {"chunk": {"data": plan()}})
        name = f"{site}/priorMaps/plan"
        self.ok("PriorMapService.GetPriorMap", {"name": name})
        self.ok("PriorMapService.ListPriorMaps", {"parent": site, "page_size": 1})
        self.ok("PriorMapService.UpdatePriorMap", {"prior_map": {"name": name, "display_name": "Plan"},
                                                   "update_mask": {"paths": ["display_name"]}})
        pairs = [{"sheet_x": on_sheet(x, y)[0], "sheet_y": on_sheet(x, y)[1], "map": f"{site}/maps/m", "x_m": x + 1, "y_m": y + 1}
                 for x, y in ((0, 0), (14, 0), (5, 9))]
        self.ok("PriorMapService.AlignPriorMap", {"name": name, "pairs": pairs})
        self.ok("PriorMapService.ActivatePriorMap", {"name": name})
        scans = [{"scan": scan(i), "pose_odom_robot": {"x": 0.1 * i}} for i in range(0, 31, 3)]
        self.ok("PriorMapService.LocateInPriorMap", {"name": name, "scans": scans})
        self.ok("PriorMapService.ListPriorAssociations", {"parent": name, "page_size": 3})
        self.ok("PriorMapService.ListPredictedLinkPoints", {"parent": name, "page_size": 3})
        self.ok("PriorMapService.SuspendPriorMap", {"name": name})
        self.ok("PriorMapService.ExportPriorMap", {"name": name})
        self.ok("PriorMapService.EditPriorMap", {"name": name, "plan": plan().decode(), "validate_only": True,
                                                 "measure": {"to_x": 100, "length_m": 5}})
        self.ok("PriorMapService.DeletePriorMap", {"name": f"{site}/priorMaps/spare", "force": True})

    def map_edits(self):
        """Of a map of their own, which a robot contests: people erase its walls, and the next session sees them again."""
        self.ok("MapService.CreateMap", {"parent": self.site, "map_id": "e",
                                         "map": {"display_name": "e", "environment": INDOOR}})
        edited = f"{self.site}/maps/e"
        self.await_mapped(self.drive("before-edits", "e"))
        for draft in ("d", "spare"):
            self.ok("MapEditService.CreateMapDraft", {"parent": edited, "draft_id": draft, "request_id": "draft-" + draft,
                                                      "draft": {"display_name": draft, "author": "ann"}})
        name = f"{edited}/drafts/d"
        self.ok("MapEditService.GetMapDraft", {"name": name})
        self.ok("MapEditService.ListMapDrafts", {"parent": edited, "page_size": 1, "state": 1})
        self.ok("MapEditService.DeleteMapDraft", {"name": f"{edited}/drafts/spare"})
        read = self.one("MapEditService.ReadMapDraftTiles", {"name": name})
        self.ok("MapEditService.ReadMapDraftTiles", {"name": name, "tiles": [
            {"row": tile.row, "column": tile.column} for tile in read.known_tiles[:2]]})
        self.draw(name, read.box)
        self.ok("MapEditService.SetMapEditsActive", {"name": name, "edit_ids": ["line"], "active": False, "author": "ann"})
        self.ok("MapEditService.ListMapEdits", {"parent": name, "page_size": 2})
        self.ok("MapEditService.ReportMapDraftPresence", {"name": name, "presence": {
            "client_id": "c", "author": "ann", "pointer": {"x": 5, "y": -5}, "tool": "brush"}})
        self.ok("MapEditService.WatchMapDraft", {"name": name}, enough=1)
        check = self.one("MapEditService.CheckMapDraft", {"name": name})
        self.ok("MapEditService.RebaseMapDraft", {"name": name, "edit_version": check.edit_version, "author": "ann",
                                                  "resolutions": [{"box": {"width": 1, "height": 1}, "choice": MINE}]})
        self.ok("MapEditService.PublishMapDraft", {"name": name, "message": "no walls", "confirm_warnings": True})
        self.await_mapped(self.drive("after-edits", "e"))
        contested = self.one("MapEditService.ListContestedEdits", {"parent": edited}).contested
        if not contested:
            raise TourError(f"nothing is contested in {edited}")
        settled = [{"box": contested[0].box, "session": contested[0].session, "choice": KEEP}]
        self.ok("MapEditService.SettleContestedEdits", {"parent": edited, "message": "seen again", "author": "ann",
                                                        "settlements": settled})

    def draw(self, draft, box):
        """Edits of each shape in the box, the last of which erases all walls."""
        left, low = 256 * box.first_column, 256 * box.first_row
        right, high = left + 256 * box.width, low + 256 * box.height
        middle = {"x": (left + right) // 2, "y": (low + high) // 2}
        ring = [{"x": left, "y": low}, {"x": right, "y": low}, {"x": right, "y": high}, {"x": left, "y": high}]
        shapes = [("brush", {"value": OCCUPIED, "brush": {"points": [middle, ring[0]], "radius": 300}, "invisible": True}),
                  ("line", {"value": FREE, "line": {"points": [middle, ring[1]]}}),
                  ("patch", {"value": CLEAR, "patch": {"box": box, "runs": [0, 3, 5, 1]}}),
                  ("fill", {"value": FREE, "fill": {"seed": middle, "bounds": box}}),
                  ("walls", {"value": FREE, "polygon": {"rings": [{"points": ring}]}, "only_where": [OCCUPIED]})]
        self.ok("MapEditService.AppendMapEdits", {"name": draft, "edits": [
            {"edit_id": edit_id, "author": "ann", **shape} for edit_id, shape in shapes]})

    def localize(self):
        self.ok("LocalizationService.LocalizeRobot", {"site": self.site, "scans": [{"scan": scan(3)}]})

    def closures(self, session):
        """Of a session elsewhere, which has some."""
        found = self.one("SessionService.ListClosures", {"parent": session}).closures
        if not found:
            raise TourError(f"{session} has no closures")
        name = random.Random(self.site).choice(found).name
        self.ok("SessionService.SuspendClosure", {"name": name})
        self.ok("SessionService.ResumeClosure", {"name": name})

    def clear(self):
        """Deletes the sites, if they are still there."""
        method = self.api.methods["SiteService.DeleteSite"]
        for site in (self.site, self.site + "-plan"):
            request = method.request(name=site, force=True)
            self.counts.add(method.name, self.api.call(method, [request.SerializeToString()], timeout=TIMEOUT_S))
