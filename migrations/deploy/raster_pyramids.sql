-- SPDX-License-Identifier: Apache-2.0
-- What viewers of maps see: the tiles of revisions at all zooms. Made when somebody looks at a revision.
BEGIN;

CREATE TABLE enfilade.raster_pyramids (
  site_id        text COLLATE "C" NOT NULL,
  map_id         enfilade.resource_id NOT NULL,
  revision       bigint NOT NULL,
  display_only   boolean NOT NULL,  -- zoom 0 is made from cells of another form
  lattice_column integer NOT NULL,  -- of the raster's lower-left cell on the lattice of tiles
  lattice_row    integer NOT NULL,
  -- A picture of at most 64 x 64 cells: its zoom, its lower-left cell on the lattice of that zoom, one byte a cell.
  thumbnail_zoom   smallint NOT NULL,
  thumbnail_column integer NOT NULL,
  thumbnail_row    integer NOT NULL,
  thumbnail_width  integer NOT NULL CHECK (thumbnail_width BETWEEN 1 AND 64),
  thumbnail_cells  bytea NOT NULL CHECK (octet_length(thumbnail_cells) BETWEEN 1 AND 4096),
  PRIMARY KEY (site_id, map_id, revision),
  FOREIGN KEY (site_id, map_id, revision) REFERENCES enfilade.map_revisions ON DELETE CASCADE
);
CREATE TABLE enfilade.raster_pyramid_tiles (
  site_id     text COLLATE "C" NOT NULL,
  map_id      enfilade.resource_id NOT NULL,
  revision    bigint NOT NULL,
  zoom        smallint NOT NULL CHECK (zoom BETWEEN 0 AND 31),
  tile_row    integer NOT NULL,
  tile_column integer NOT NULL,
  sha256      enfilade.sha256_digest NOT NULL,
  PRIMARY KEY (site_id, map_id, revision, zoom, tile_row, tile_column),
  FOREIGN KEY (site_id, map_id, revision) REFERENCES enfilade.raster_pyramids ON DELETE CASCADE,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs
);
CREATE INDEX raster_pyramid_tiles_blob_idx ON enfilade.raster_pyramid_tiles (site_id, sha256);
CREATE TRIGGER list_blob AFTER DELETE ON enfilade.raster_pyramid_tiles FOR EACH ROW EXECUTE FUNCTION enfilade.list_blob();
CREATE TRIGGER list_replaced_blob AFTER UPDATE OF sha256 ON enfilade.raster_pyramid_tiles FOR EACH ROW
  WHEN (OLD.sha256 <> NEW.sha256) EXECUTE FUNCTION enfilade.list_blob();

INSERT INTO enfilade.schema_compatibility VALUES ('raster_pyramids', 'raster_pyramids');
COMMIT;
