-- SPDX-License-Identifier: Apache-2.0
-- Parts of maps with a meaning: keep-out, speed limits, rooms and others. A merged or split map's areas move with it.
BEGIN;

CREATE TABLE enfilade.map_areas (
  site_id        text COLLATE "C" NOT NULL,
  map_id         enfilade.resource_id NOT NULL,
  area_id        enfilade.resource_id NOT NULL,
  display_name   enfilade.display_name NOT NULL,
  kind           smallint NOT NULL CHECK (kind BETWEEN 1 AND 6),  -- keep-out, speed limit, preferred, ignore hits, room, dock
  outline        geometry(Polygon, 0) NOT NULL,  -- m, in the map's frame; simple, which the server checks
  robot_types    text[] NOT NULL DEFAULT '{}' CHECK (cardinality(robot_types) <= 20),  -- {}: all
  speed_limit    double precision NOT NULL DEFAULT 0,  -- m/s; 0: none
  valid_from     timestamptz,  -- NULL: without an end
  valid_until    timestamptz,
  request_id     text,
  request_sha256 bytea,
  etag           bigint NOT NULL,
  create_time    timestamptz NOT NULL DEFAULT now(),
  update_time    timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, map_id, area_id),
  UNIQUE (site_id, request_id),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE,
  CONSTRAINT map_areas_outline_check CHECK (ST_NPoints(outline) BETWEEN 4 AND 1001),
  CONSTRAINT map_areas_speed_check CHECK (CASE WHEN kind = 2 THEN speed_limit > 0 AND speed_limit < 'Infinity'
    ELSE speed_limit = 0 END),
  CONSTRAINT map_areas_validity_check CHECK (valid_from < valid_until)
);
CREATE INDEX map_areas_kind_idx ON enfilade.map_areas (site_id, map_id, kind);
CREATE TRIGGER map_areas_deleted_site BEFORE INSERT ON enfilade.map_areas
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_in_deleted_site();
CREATE TRIGGER map_areas_audit AFTER INSERT OR UPDATE OR DELETE ON enfilade.map_areas
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('maps/%s/areas/%s', 'map_id', 'area_id');

-- What a rearrangement changes now includes areas, by map/area. NULL: there is none.
ALTER FUNCTION enfilade.rearrangement_image(text, text, text) RENAME TO rearrangement_image_but_areas;
CREATE FUNCTION enfilade.rearrangement_image(site text, relation text, key text) RETURNS jsonb LANGUAGE plpgsql STABLE AS $$
BEGIN
  IF relation <> 'area' THEN RETURN enfilade.rearrangement_image_but_areas(site, relation, key); END IF;
  RETURN (SELECT to_jsonb(a) || jsonb_build_object('outline', a.outline::text) FROM enfilade.map_areas a
    WHERE a.site_id = site AND a.map_id = split_part(key, '/', 1) AND a.area_id = split_part(key, '/', 2));
END $$;

-- An older server leaves the areas of a map behind when it merges or splits it.
INSERT INTO enfilade.schema_compatibility VALUES ('map_areas', 'map_areas');
COMMIT;
