-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, map_id, position, session_id, revision, raster_header, version FROM enfilade.map_layers WHERE false;
SELECT site_id, map_id, position, tile_row, tile_column, sha256 FROM enfilade.map_layer_tiles WHERE false;

ROLLBACK;
