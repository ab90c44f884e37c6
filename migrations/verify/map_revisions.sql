-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, map_id, revision, source, session_id, resolution, origin_x, origin_y, origin_yaw, width, height,
  raster_header, content_sha256, tile_count, tile_bytes, create_time
FROM enfilade.map_revisions WHERE false;
SELECT site_id, map_id, revision, tile_row, tile_column, sha256 FROM enfilade.map_revision_tiles WHERE false;

ROLLBACK;
