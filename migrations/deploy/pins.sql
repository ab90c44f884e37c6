-- SPDX-License-Identifier: Apache-2.0
-- What people have decided of maps and link points, surveys leave as it is.
BEGIN;

ALTER TABLE enfilade.maps ADD COLUMN pinned boolean NOT NULL DEFAULT false;
ALTER TABLE enfilade.link_points ADD COLUMN pinned boolean NOT NULL DEFAULT false;

DROP TRIGGER maps_audit ON enfilade.maps;
CREATE TRIGGER maps_audit
  AFTER INSERT OR UPDATE OF display_name, level, environment, slam_profile, outline, pinned OR DELETE ON enfilade.maps
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('maps/%s', 'map_id');
DROP TRIGGER link_points_audit ON enfilade.link_points;
CREATE TRIGGER link_points_audit
  AFTER INSERT OR UPDATE OF kind, tag, direction_map_id, difficulty, environment, state, valid_until, "use", forced, pinned
  OR DELETE ON enfilade.link_points
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('linkPoints/%s', 'link_point_id');

-- Images from before this have no pins: one that is not pinned has none either.
ALTER FUNCTION enfilade.rearrangement_image(text, text, text) RENAME TO rearrangement_image_but_pins;
CREATE FUNCTION enfilade.rearrangement_image(site text, relation text, key text) RETURNS jsonb LANGUAGE plpgsql STABLE AS $$
DECLARE
  image jsonb := enfilade.rearrangement_image_but_pins(site, relation, key);
BEGIN
  IF relation = 'link_point' AND image #>> '{link_point,pinned}' = 'false' THEN
    RETURN image #- '{link_point,pinned}';
  END IF;
  RETURN image;
END $$;

INSERT INTO enfilade.schema_compatibility VALUES ('pins', 'pins');
COMMIT;
