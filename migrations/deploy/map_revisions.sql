-- SPDX-License-Identifier: Apache-2.0
-- Rasters of maps: immutable revisions, each a manifest of tiles whose content is shared between revisions.
BEGIN;

CREATE TABLE enfilade.map_revisions (
  site_id        enfilade.resource_id NOT NULL,
  map_id         enfilade.resource_id NOT NULL,
  revision       bigint NOT NULL CHECK (revision >= 1),
  source         smallint NOT NULL,
  session_id     enfilade.resource_id,
  resolution     double precision NOT NULL,  -- m, the side of a cell
  origin_x       double precision NOT NULL,  -- the pose of cell (0, 0)'s lower-left corner in the map's frame: m, m, rad
  origin_y       double precision NOT NULL,
  origin_yaw     double precision NOT NULL,
  width          integer NOT NULL,           -- cells
  height         integer NOT NULL,
  raster_header  bytea NOT NULL CHECK (octet_length(raster_header) <= 1048576),
  content_sha256 enfilade.sha256_digest NOT NULL,
  tile_count     bigint NOT NULL CHECK (tile_count >= 0),
  tile_bytes     bigint NOT NULL CHECK (tile_bytes >= 0),  -- of all tiles' blobs
  create_time    timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, map_id, revision),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE,
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions,
  CONSTRAINT map_revisions_source_check CHECK (source IN (1, 2)),  -- mapping, import
  CONSTRAINT map_revisions_session_check CHECK ((source = 1) = (session_id IS NOT NULL)),
  CONSTRAINT map_revisions_geometry_check CHECK (
    resolution > 0 AND resolution < 'Infinity' AND width >= 0 AND height >= 0
    AND origin_x > '-Infinity' AND origin_x < 'Infinity' AND origin_y > '-Infinity' AND origin_y < 'Infinity'
    AND origin_yaw > '-Infinity' AND origin_yaw < 'Infinity')
);
CREATE INDEX map_revisions_session_idx ON enfilade.map_revisions (site_id, session_id) WHERE session_id IS NOT NULL;

CREATE TABLE enfilade.map_revision_tiles (
  site_id     enfilade.resource_id NOT NULL,
  map_id      enfilade.resource_id NOT NULL,
  revision    bigint NOT NULL,
  tile_row    integer NOT NULL,
  tile_column integer NOT NULL,
  sha256      enfilade.sha256_digest NOT NULL,
  PRIMARY KEY (site_id, map_id, revision, tile_row, tile_column),
  FOREIGN KEY (site_id, map_id, revision) REFERENCES enfilade.map_revisions ON DELETE CASCADE,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs
);
CREATE INDEX map_revision_tiles_blob_idx ON enfilade.map_revision_tiles (site_id, sha256);

COMMIT;
