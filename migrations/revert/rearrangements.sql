-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP FUNCTION enfilade.rearrangement_image(text, text, text);
DROP TABLE enfilade.rearrangement_blobs;
DROP TABLE enfilade.rearrangement_images;
DROP TABLE enfilade.rearrangement_parts;
DROP TABLE enfilade.rearrangements;
DROP TRIGGER link_point_anchors_redirected ON enfilade.link_point_anchors;
DROP TRIGGER control_points_redirect ON enfilade.control_points;
DROP TRIGGER robot_poses_redirect ON enfilade.robot_poses;
DROP TRIGGER sessions_redirect ON enfilade.sessions;
DROP FUNCTION enfilade.refuse_redirected_anchor();
DROP FUNCTION enfilade.redirect_control_point();
DROP FUNCTION enfilade.redirect_robot_pose();
DROP FUNCTION enfilade.redirect_session();
DROP FUNCTION enfilade.follow_redirect(text, text);
DROP FUNCTION enfilade.rotate_covariance(double precision[], double precision);
DROP FUNCTION enfilade.wrap_angle(double precision);
DROP FUNCTION enfilade.resolve_map(text, text);
-- The maps that were merged into others are gone for good.
DELETE FROM enfilade.maps WHERE redirect_map_id IS NOT NULL;
ALTER TABLE enfilade.maps
  DROP CONSTRAINT maps_redirect_check,
  DROP COLUMN redirect_map_id,
  DROP COLUMN redirect_x,
  DROP COLUMN redirect_y,
  DROP COLUMN redirect_yaw;

-- The rest of a session that was cut stays a session. Its counts take in the records that it skips.
ALTER TABLE enfilade.sessions DROP CONSTRAINT sessions_count_check;
UPDATE enfilade.sessions SET laser_scans = laser_scans + skipped_records WHERE skipped_records > 0;
ALTER TABLE enfilade.sessions
  DROP COLUMN cut_from_session_id,
  DROP COLUMN recorded_sequence,
  DROP COLUMN skipped_records,
  ADD CONSTRAINT sessions_count_check CHECK (
    laser_scans >= 0 AND odometry >= 0 AND images >= 0 AND point_clouds >= 0 AND withheld >= 0 AND door_reports >= 0
    AND payload_bytes >= 0
    AND laser_scans + odometry + images + point_clouds + withheld + door_reports
        BETWEEN acknowledged_sequence AND highest_sequence);

UPDATE enfilade.site_graphs SET cause = 2 WHERE cause = 9;
DELETE FROM enfilade.graph_versions WHERE cause = 9;
ALTER TABLE enfilade.site_graphs DROP CONSTRAINT site_graphs_cause_check,
  ADD CONSTRAINT site_graphs_cause_check CHECK (cause BETWEEN 1 AND 8);

CREATE OR REPLACE FUNCTION enfilade.add_map_to_graph() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  version bigint;
  root boolean;
BEGIN
  INSERT INTO enfilade.site_graphs AS g (site_id, graph_version, root_map_id, cause, resource)
    VALUES (NEW.site_id, 1, NEW.map_id, 1, 'maps/' || NEW.map_id)
    ON CONFLICT (site_id) DO UPDATE SET graph_version = g.graph_version + 1,
      root_map_id = coalesce(g.root_map_id, NEW.map_id), cause = 1, resource = 'maps/' || NEW.map_id
    RETURNING graph_version, root_map_id = NEW.map_id INTO version, root;
  IF root THEN
    INSERT INTO enfilade.graph_maps (site_id, map_id, changed_version, x, y, yaw, covariance)
      VALUES (NEW.site_id, NEW.map_id, version, 0, 0, 0, array_fill(0::double precision, '{9}'));
  ELSE
    INSERT INTO enfilade.graph_maps (site_id, map_id, changed_version) VALUES (NEW.site_id, NEW.map_id, version);
  END IF;
  RETURN NULL;
END $$;
CREATE OR REPLACE FUNCTION enfilade.follow_anchors() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  changed record;
BEGIN
  IF TG_OP = 'DELETE' THEN changed := OLD; ELSE changed := NEW; END IF;
  UPDATE enfilade.link_points p SET anchor_count = a.count, levels = a.levels
  FROM (SELECT count(*) AS count,
      coalesce(range_agg(int4range(m.level, m.level, '[]')), '{}') AS levels
    FROM enfilade.link_point_anchors c JOIN enfilade.maps m ON m.site_id = c.site_id AND m.map_id = c.map_id
    WHERE c.site_id = changed.site_id AND c.link_point_id = changed.link_point_id) a
  WHERE p.site_id = changed.site_id AND p.link_point_id = changed.link_point_id
    AND (p.anchor_count, p.levels) IS DISTINCT FROM (a.count::integer, a.levels);
  IF TG_OP <> 'DELETE' THEN
    PERFORM enfilade.refuse_redundant_link_point(changed.site_id, changed.link_point_id, TG_OP = 'INSERT');
  END IF;
  RETURN NULL;
END $$;

COMMIT;
