-- SPDX-License-Identifier: Apache-2.0
-- Runs of old layers, overlaid beforehand, so that a revision costs the same however many sessions a map has.
BEGIN;

-- The layers of a map as a whole. It outlives its layers.
CREATE TABLE enfilade.map_layer_stacks (
  site_id text COLLATE "C" NOT NULL,
  map_id  enfilade.resource_id NOT NULL,
  version bigint NOT NULL,  -- counts changes of layers, also of those that went
  PRIMARY KEY (site_id, map_id),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE
);

-- Derived from the layers at these positions, which stay, and deleted when one of them changes or goes.
CREATE TABLE enfilade.map_layer_runs (
  site_id        text COLLATE "C" NOT NULL,
  map_id         enfilade.resource_id NOT NULL,
  first_position bigint NOT NULL,
  last_position  bigint NOT NULL CHECK (last_position > first_position),
  resolution     double precision NOT NULL,  -- m; of the cells to which the layers were resampled
  reset_header   bytea CHECK (octet_length(reset_header) <= 1048576),  -- NULL: unknown everywhere
  content_header bytea NOT NULL CHECK (octet_length(content_header) <= 1048576),
  PRIMARY KEY (site_id, map_id, first_position),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.map_layer_stacks ON DELETE CASCADE
);
CREATE TABLE enfilade.map_layer_run_tiles (
  site_id        text COLLATE "C" NOT NULL,
  map_id         enfilade.resource_id NOT NULL,
  first_position bigint NOT NULL,
  part           smallint NOT NULL CHECK (part IN (1, 2)),  -- 1 reset, 2 content
  tile_row       integer NOT NULL,
  tile_column    integer NOT NULL,
  sha256         enfilade.sha256_digest NOT NULL,
  PRIMARY KEY (site_id, map_id, first_position, part, tile_row, tile_column),
  FOREIGN KEY (site_id, map_id, first_position) REFERENCES enfilade.map_layer_runs ON DELETE CASCADE,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs
);
CREATE INDEX map_layer_run_tiles_blob_idx ON enfilade.map_layer_run_tiles (site_id, sha256);

-- From now on the version of a layer is that of the layers as a whole when it last changed.
ALTER TABLE enfilade.map_layers ALTER version DROP DEFAULT;
INSERT INTO enfilade.map_layer_stacks SELECT site_id, map_id, max(version) FROM enfilade.map_layers GROUP BY 1, 2;

INSERT INTO enfilade.schema_compatibility VALUES ('layer_runs', 'layer_runs');
COMMIT;
