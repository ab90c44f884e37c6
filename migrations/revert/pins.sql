-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'pins';

DROP FUNCTION enfilade.rearrangement_image(text, text, text);
ALTER FUNCTION enfilade.rearrangement_image_but_pins(text, text, text) RENAME TO rearrangement_image;
UPDATE enfilade.rearrangement_images SET before = before #- '{link_point,pinned}', after = after #- '{link_point,pinned}'
  WHERE relation = 'link_point';

DROP TRIGGER maps_audit ON enfilade.maps;
CREATE TRIGGER maps_audit
  AFTER INSERT OR UPDATE OF display_name, level, environment, slam_profile, outline OR DELETE ON enfilade.maps
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('maps/%s', 'map_id');
DROP TRIGGER link_points_audit ON enfilade.link_points;
CREATE TRIGGER link_points_audit
  AFTER INSERT OR UPDATE OF kind, tag, direction_map_id, difficulty, environment, state, valid_until, "use", forced
  OR DELETE ON enfilade.link_points
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('linkPoints/%s', 'link_point_id');

ALTER TABLE enfilade.link_points DROP COLUMN pinned;
ALTER TABLE enfilade.maps DROP COLUMN pinned;
COMMIT;
