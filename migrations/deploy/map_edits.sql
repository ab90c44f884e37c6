-- SPDX-License-Identifier: Apache-2.0
-- What people edit in maps: drafts with their edits, and the overlay that published ones make.
BEGIN;

CREATE TABLE enfilade.map_drafts (
  site_id      text COLLATE "C" NOT NULL,
  map_id       enfilade.resource_id NOT NULL,
  draft_id     enfilade.resource_id NOT NULL,
  display_name text NOT NULL,
  author       text NOT NULL,
  base_edit_version bigint NOT NULL,  -- the map's edits that it lies over
  resolution   double precision NOT NULL CHECK (resolution > 0 AND resolution < 'Infinity'),  -- m; of its lattice's cells
  origin_x     double precision NOT NULL,  -- of its lattice in the map's frame: m, m, rad
  origin_y     double precision NOT NULL,
  origin_yaw   double precision NOT NULL,
  head         bigint NOT NULL DEFAULT 0,  -- grows with every change of its edits
  next_sequence bigint NOT NULL DEFAULT 1,
  active_edits bigint NOT NULL DEFAULT 0,
  create_time  timestamptz NOT NULL DEFAULT now(),
  etag         bigint NOT NULL DEFAULT nextval('enfilade.etags'),
  -- Of a published one; all NULL: it is open.
  publish_time timestamptz,
  edit_version bigint,
  revision     bigint,
  message      text,
  PRIMARY KEY (site_id, map_id, draft_id),
  UNIQUE (site_id, map_id, edit_version),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE,
  CONSTRAINT map_drafts_published_check CHECK (num_nulls(publish_time, edit_version, revision, message) IN (0, 4))
);
CREATE INDEX map_drafts_time_idx ON enfilade.map_drafts (site_id, map_id, create_time, draft_id);
CREATE TRIGGER map_drafts_deleted_site BEFORE INSERT ON enfilade.map_drafts
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_in_deleted_site();
CREATE TRIGGER map_drafts_audit AFTER INSERT OR DELETE OR UPDATE OF etag ON enfilade.map_drafts
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('maps/%s/drafts/%s', 'map_id', 'draft_id');

CREATE TABLE enfilade.map_edits (
  site_id     text COLLATE "C" NOT NULL,
  map_id      enfilade.resource_id NOT NULL,
  draft_id    enfilade.resource_id NOT NULL,
  sequence    bigint NOT NULL,  -- later edits lie over earlier ones
  edit_id     text COLLATE "C" NOT NULL,
  author      text NOT NULL,
  head        bigint NOT NULL,  -- of its draft, when it last changed
  active      boolean NOT NULL DEFAULT true,
  instruction smallint NOT NULL CHECK (instruction BETWEEN 1 AND 4),  -- unknown, free, occupied, clear
  invisible   boolean NOT NULL,
  shape       bytea NOT NULL CHECK (octet_length(shape) <= 33554432),
  create_time timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, map_id, draft_id, sequence),
  UNIQUE (site_id, map_id, draft_id, edit_id),
  FOREIGN KEY (site_id, map_id, draft_id) REFERENCES enfilade.map_drafts ON DELETE CASCADE
);
CREATE INDEX map_edits_head_idx ON enfilade.map_edits (site_id, map_id, draft_id, head, sequence);

-- What the published edits of a map make, and what its newest revision is without them.
CREATE TABLE enfilade.map_overlays (
  site_id       text COLLATE "C" NOT NULL,
  map_id        enfilade.resource_id NOT NULL,
  edit_version  bigint NOT NULL,  -- of the newest publication
  first_version bigint NOT NULL,  -- publications before it count no longer: an import has replaced the map
  resolution    double precision NOT NULL,
  origin_x      double precision NOT NULL,
  origin_y      double precision NOT NULL,
  origin_yaw    double precision NOT NULL,
  evidence_header bytea CHECK (octet_length(evidence_header) <= 1048576),  -- NULL: the revision itself
  PRIMARY KEY (site_id, map_id),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE
);
CREATE TABLE enfilade.map_overlay_tiles (
  site_id     text COLLATE "C" NOT NULL,
  map_id      enfilade.resource_id NOT NULL,
  part        smallint NOT NULL CHECK (part IN (1, 2)),  -- 1 instructions, 2 evidence
  tile_row    integer NOT NULL,
  tile_column integer NOT NULL,
  sha256      enfilade.sha256_digest NOT NULL,
  PRIMARY KEY (site_id, map_id, part, tile_row, tile_column),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.map_overlays ON DELETE CASCADE,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs
);
CREATE INDEX map_overlay_tiles_blob_idx ON enfilade.map_overlay_tiles (site_id, sha256);
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.map_overlay_tiles FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.map_overlay_tiles FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();

ALTER TABLE enfilade.map_revisions ADD edit_version bigint NOT NULL DEFAULT 0;  -- 0: no edits lie over it
-- How many publications there were when the session began to be mapped: it has seen what they edited.
ALTER TABLE enfilade.map_layers ADD edit_version bigint NOT NULL DEFAULT 0;

INSERT INTO enfilade.schema_compatibility VALUES ('map_edits', 'map_edits');
COMMIT;
