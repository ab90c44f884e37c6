-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'map_areas';
DROP FUNCTION enfilade.rearrangement_image(text, text, text);
ALTER FUNCTION enfilade.rearrangement_image_but_areas(text, text, text) RENAME TO rearrangement_image;
-- Older programs know no images of areas; rearrangements that moved some stay, without them.
DELETE FROM enfilade.rearrangement_images WHERE relation = 'area';
DROP TABLE enfilade.map_areas;
COMMIT;
