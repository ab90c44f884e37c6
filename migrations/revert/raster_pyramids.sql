-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'raster_pyramids';
-- Their blobs may be unused from now on.
INSERT INTO enfilade.loose_blobs (site_id, sha256, since)
  SELECT DISTINCT site_id, sha256, '-infinity'::timestamptz FROM enfilade.raster_pyramid_tiles;
DROP TABLE enfilade.raster_pyramid_tiles;
DROP TABLE enfilade.raster_pyramids;
COMMIT;
