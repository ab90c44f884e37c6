-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'map_edits';
ALTER TABLE enfilade.map_layers DROP COLUMN edit_version;
ALTER TABLE enfilade.map_revisions DROP COLUMN edit_version;
-- Their blobs may be unused from now on.
INSERT INTO enfilade.loose_blobs (site_id, sha256, since)
  SELECT DISTINCT site_id, sha256, '-infinity'::timestamptz FROM enfilade.map_overlay_tiles;
DROP TABLE enfilade.map_overlay_tiles;
DROP TABLE enfilade.map_overlays;
DROP TABLE enfilade.map_edits;
DROP TABLE enfilade.map_drafts;
COMMIT;
