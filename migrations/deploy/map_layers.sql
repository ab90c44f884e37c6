-- SPDX-License-Identifier: Apache-2.0
-- The layers of maps' revisions: what was imported, and above it what each session has seen.
BEGIN;

-- Position 1 is the bottom. A layer that was a whole revision when it was stored refers to that revision; any other has
-- its own tiles. Layers are deleted with their map only: the layer of a deleted session stays.
CREATE TABLE enfilade.map_layers (
  site_id       enfilade.resource_id NOT NULL,
  map_id        enfilade.resource_id NOT NULL,
  position      bigint NOT NULL CHECK (position >= 1),
  session_id    enfilade.resource_id,  -- NULL: an import, or a revision from before layers were stored
  revision      bigint,
  raster_header bytea CHECK (octet_length(raster_header) <= 1048576),
  version       bigint NOT NULL DEFAULT nextval('enfilade.etags'),  -- a new one with every change: the map's maximum grows
  PRIMARY KEY (site_id, map_id, position),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE,
  FOREIGN KEY (site_id, map_id, revision) REFERENCES enfilade.map_revisions ON DELETE CASCADE,
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions,
  CONSTRAINT map_layers_content_check CHECK ((revision IS NULL) = (raster_header IS NOT NULL))
) WITH (fillfactor = 50);
CREATE UNIQUE INDEX map_layers_session_idx ON enfilade.map_layers (site_id, map_id, session_id)
  WHERE session_id IS NOT NULL;

CREATE TABLE enfilade.map_layer_tiles (
  site_id     enfilade.resource_id NOT NULL,
  map_id      enfilade.resource_id NOT NULL,
  position    bigint NOT NULL,
  tile_row    integer NOT NULL,
  tile_column integer NOT NULL,
  sha256      enfilade.sha256_digest NOT NULL,
  PRIMARY KEY (site_id, map_id, position, tile_row, tile_column),
  FOREIGN KEY (site_id, map_id, position) REFERENCES enfilade.map_layers ON DELETE CASCADE,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs
);
CREATE INDEX map_layer_tiles_blob_idx ON enfilade.map_layer_tiles (site_id, sha256);

INSERT INTO enfilade.map_layers (site_id, map_id, position, session_id, revision)
SELECT m.site_id, m.map_id, 1, r.session_id, r.revision FROM enfilade.maps m
JOIN enfilade.map_revisions r ON (r.site_id, r.map_id, r.revision) = (m.site_id, m.map_id, m.current_revision);

COMMIT;
