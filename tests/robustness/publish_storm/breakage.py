# SPDX-License-Identifier: Apache-2.0
"""Breaks what is stored, in one way after the other, to see whether the oracle finds it: a check of the check."""
import os
import subprocess
from pathlib import Path

from . import calls

OF_MAP = "site_id = :'site' AND map_id = 'm'"
SAME_TILE = "(o.site_id, o.map_id, o.tile_row, o.tile_column) = (t.site_id, t.map_id, t.tile_row, t.tile_column)"
# Each changes something, or the interleaving before it was none for it.
WAYS = {
    "an edit is gone": f"DELETE FROM map_edits WHERE {OF_MAP} AND edit_id = :'edit' RETURNING 1",
    "an edit is there twice":
        "INSERT INTO map_edits (site_id, map_id, draft_id, sequence, edit_id, author, head, instruction, invisible, shape)"
        " SELECT site_id, map_id, draft_id, sequence + 1000, edit_id || '2', author, head, instruction, invisible, shape"
        f" FROM map_edits WHERE {OF_MAP} AND edit_id = :'edit' RETURNING 1",
    "an edit says something else":
        f"UPDATE map_edits SET instruction = instruction % 4 + 1 WHERE {OF_MAP} AND edit_id = :'edit' RETURNING 1",
    "a published draft is open again":
        "UPDATE map_drafts SET publish_time = NULL, edit_version = NULL, revision = NULL, message = NULL"
        f" WHERE {OF_MAP} AND draft_id = :'draft' RETURNING 1",
    "a publication's revision shows the one before":
        "UPDATE map_revision_tiles t SET sha256 = o.sha256 FROM map_revision_tiles o, map_revisions r"
        f" WHERE {SAME_TILE} AND o.revision = t.revision - 1 AND o.sha256 <> t.sha256 AND r.source = 3"
        " AND (r.site_id, r.map_id, r.revision) = (t.site_id, t.map_id, t.revision)"
        " AND t.site_id = :'site' AND t.map_id = 'm' RETURNING 1",
    "a later revision lacks the edits":
        f"UPDATE map_revision_tiles t SET sha256 = o.sha256 FROM map_overlay_tiles o WHERE o.part = 2 AND {SAME_TILE}"
        " AND o.sha256 <> t.sha256 AND t.site_id = :'site' AND t.map_id = 'm' AND t.revision = (SELECT max(revision)"
        f" FROM map_revisions WHERE {OF_MAP} AND source <> 3 AND edit_version > 0) RETURNING 1",
    "an edit_version goes back":
        f"UPDATE map_revisions SET edit_version = edit_version - 1 WHERE {OF_MAP} AND source <> 3 AND edit_version > 0"
        " RETURNING 1",
    # Not one that is a layer, too: the database would refuse that.
    "a revision is gone":
        f"DELETE FROM map_revisions WHERE {OF_MAP} AND revision = (SELECT min(r.revision) FROM map_revisions r WHERE"
        " r.site_id = :'site' AND r.map_id = 'm' AND r.source = 1 AND NOT EXISTS (SELECT FROM map_layers l WHERE"
        " (l.site_id, l.map_id, l.revision) = (r.site_id, r.map_id, r.revision))) AND revision < (SELECT max(revision)"
        f" FROM map_revisions WHERE {OF_MAP}) RETURNING 1",
    "a deleted map is still there": "",
}
TRIES = 12
# What an edit only takes away is not compared in older revisions: a break may happen not to be seen.
CHANCES = 3


def execute(url, sql, **values):
    """Whether it gave a row."""
    binaries = os.environ.get("ENFILADE_PG_BIN") or max(Path("/usr/lib/postgresql").glob("*/bin"))
    command = [Path(binaries) / "psql", url, "--no-psqlrc", "--quiet", "--tuples-only", "--no-align", "--set=ON_ERROR_STOP=1"]
    command += [f"--set={name}={value}" for name, value in values.items()]
    done = subprocess.run(command, input=f"SET search_path = enfilade;\n{sql};\n", capture_output=True, text=True,
                          check=False)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return bool(done.stdout.strip())


def damage(url, place, sql):
    """Whether it is done to the place."""
    if not sql:
        place.deleted = True
        return True
    drafts = [draft for draft in place.drafts.values() if draft.answer and draft.acknowledged - draft.maybe_undone]
    if not drafts:
        return False
    draft = drafts[0]
    return execute(url, sql, site=place.site.split("/")[1], draft=draft.draft_id,
                   edit=min(draft.acknowledged - draft.maybe_undone))


def unnoticed(url, lane_of):
    """The ways in which it may be broken and nobody sees it. `lane_of()`: a new lane."""
    missed = []
    for what, sql in WAYS.items():
        unseen = 0
        for number in range(TRIES):
            lane = lane_of()
            name = f"broken-{list(WAYS).index(what)}-{number}"
            lane.prepare(name)
            lane.interleave(name)
            if lane.place.deleted:
                continue
            lane.await_mapped()
            if damage(url, lane.place, sql):
                if is_found(lane):
                    break
                unseen += 1
            if unseen == CHANCES:
                missed.append(what)
                break
        else:
            missed.append(f"{what} (never tried)")
    return missed


def is_found(lane):
    try:
        lane.check()
    except calls.Fault:
        return True
    return False
