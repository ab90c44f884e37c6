-- SPDX-License-Identifier: Apache-2.0
-- Rearrangements: maps are merged and split, sessions move between them. A map that is left empty stays as a redirect
-- with its revisions, so that its old names lead to the other map and the rearrangement can be undone.
-- What tables with many rows get comes first: each statement is a transaction, none locks its table for longer than a
-- change of the catalogue takes, and they can be repeated. Columns of the domain resource_id would have each row written anew.

-- redirect_map_id: NULL: a map in use. redirect_x, redirect_y, redirect_yaw: T_redirect_map; m, m, rad.
ALTER TABLE enfilade.maps
  ADD COLUMN IF NOT EXISTS redirect_map_id text COLLATE "C",
  ADD COLUMN IF NOT EXISTS redirect_x double precision,
  ADD COLUMN IF NOT EXISTS redirect_y double precision,
  ADD COLUMN IF NOT EXISTS redirect_yaw double precision;
ALTER TABLE enfilade.maps
  DROP CONSTRAINT IF EXISTS maps_redirect_check,
  ADD CONSTRAINT maps_redirect_check CHECK (
    num_nulls(redirect_map_id, redirect_x, redirect_y, redirect_yaw) IN (0, 4)
    AND redirect_x > '-Infinity' AND redirect_x < 'Infinity' AND redirect_y > '-Infinity' AND redirect_y < 'Infinity'
    AND redirect_yaw > '-Infinity' AND redirect_yaw < 'Infinity') NOT VALID;
ALTER TABLE enfilade.maps VALIDATE CONSTRAINT maps_redirect_check;
ALTER TABLE enfilade.maps
  DROP CONSTRAINT IF EXISTS maps_site_id_redirect_map_id_fkey,
  ADD CONSTRAINT maps_site_id_redirect_map_id_fkey
    FOREIGN KEY (site_id, redirect_map_id) REFERENCES enfilade.maps ON DELETE CASCADE NOT VALID;
ALTER TABLE enfilade.maps VALIDATE CONSTRAINT maps_site_id_redirect_map_id_fkey;

-- A session that was cut: the rest of its records belongs to another session. cut_from_session_id: of a rest, the session
-- in which it was recorded. recorded_sequence: of the last record as it was recorded; NULL: never cut. skipped_records:
-- before the first one of a rest.
ALTER TABLE enfilade.sessions
  ADD COLUMN IF NOT EXISTS cut_from_session_id text COLLATE "C",
  ADD COLUMN IF NOT EXISTS recorded_sequence bigint,
  ADD COLUMN IF NOT EXISTS skipped_records bigint NOT NULL DEFAULT 0;
ALTER TABLE enfilade.sessions
  DROP CONSTRAINT IF EXISTS sessions_skipped_records_check,
  ADD CONSTRAINT sessions_skipped_records_check CHECK (skipped_records >= 0) NOT VALID;
ALTER TABLE enfilade.sessions VALIDATE CONSTRAINT sessions_skipped_records_check;
ALTER TABLE enfilade.sessions
  DROP CONSTRAINT IF EXISTS sessions_site_id_cut_from_session_id_fkey,
  ADD CONSTRAINT sessions_site_id_cut_from_session_id_fkey
    FOREIGN KEY (site_id, cut_from_session_id) REFERENCES enfilade.sessions NOT VALID;
ALTER TABLE enfilade.sessions VALIDATE CONSTRAINT sessions_site_id_cut_from_session_id_fkey;
ALTER TABLE enfilade.sessions
  DROP CONSTRAINT IF EXISTS sessions_count_check,
  ADD CONSTRAINT sessions_count_check CHECK (
    laser_scans >= 0 AND odometry >= 0 AND images >= 0 AND point_clouds >= 0 AND withheld >= 0 AND door_reports >= 0
    AND payload_bytes >= 0
    AND skipped_records + laser_scans + odometry + images + point_clouds + withheld + door_reports
        BETWEEN acknowledged_sequence AND highest_sequence) NOT VALID;
ALTER TABLE enfilade.sessions VALIDATE CONSTRAINT sessions_count_check;

SET lock_timeout = 0;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.maps_redirect_idx;
CREATE INDEX CONCURRENTLY maps_redirect_idx ON enfilade.maps (site_id, redirect_map_id) WHERE redirect_map_id IS NOT NULL;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.sessions_cut_from_idx;
CREATE INDEX CONCURRENTLY sessions_cut_from_idx ON enfilade.sessions (site_id, cut_from_session_id)
  WHERE cut_from_session_id IS NOT NULL;
RESET lock_timeout;

BEGIN;

-- The map that a name leads to, through all redirects, and T_map_asked. The map itself, whether or not it exists, if it
-- is none.
CREATE FUNCTION enfilade.resolve_map(site text, asked text, OUT map_id text, OUT x double precision,
    OUT y double precision, OUT yaw double precision)
  LANGUAGE sql STABLE AS $$
  WITH RECURSIVE chain (id, x, y, yaw, depth) AS (
    SELECT asked COLLATE "C", 0::double precision, 0::double precision, 0::double precision, 0
    UNION ALL
    SELECT m.redirect_map_id::text, m.redirect_x + cos(m.redirect_yaw) * c.x - sin(m.redirect_yaw) * c.y,
      m.redirect_y + sin(m.redirect_yaw) * c.x + cos(m.redirect_yaw) * c.y, c.yaw + m.redirect_yaw, c.depth + 1
    FROM chain c JOIN enfilade.maps m ON m.site_id = site AND m.map_id = c.id WHERE m.redirect_map_id IS NOT NULL)
  SELECT id, x, y, yaw FROM chain ORDER BY depth DESC LIMIT 1
$$;

CREATE FUNCTION enfilade.wrap_angle(angle double precision) RETURNS double precision
  LANGUAGE sql IMMUTABLE PARALLEL SAFE AS $$
  SELECT CASE WHEN angle >= -pi() AND angle < pi() THEN angle ELSE angle - 2 * pi() * floor((angle + pi()) / (2 * pi())) END
$$;

-- A covariance of (x, y, yaw), row by row, in a frame that is turned by `yaw`: R C R'.
CREATE FUNCTION enfilade.rotate_covariance(c double precision[], yaw double precision) RETURNS double precision[]
  LANGUAGE sql IMMUTABLE PARALLEL SAFE AS $$
  SELECT CASE WHEN c IS NULL OR yaw = 0 THEN c ELSE ARRAY[
    v.k * v.k * c[1] - 2 * v.k * v.s * c[2] + v.s * v.s * c[5],
    v.k * v.s * (c[1] - c[5]) + (v.k * v.k - v.s * v.s) * c[2], v.k * c[3] - v.s * c[6],
    v.k * v.s * (c[1] - c[5]) + (v.k * v.k - v.s * v.s) * c[2],
    v.s * v.s * c[1] + 2 * v.k * v.s * c[2] + v.k * v.k * c[5], v.s * c[3] + v.k * c[6],
    v.k * c[3] - v.s * c[6], v.s * c[3] + v.k * c[6], c[9]] END
  FROM (SELECT cos(yaw) AS k, sin(yaw) AS s) v
$$;

-- What is written under the old name of a map goes to the map that it leads to, in its frame. The lock waits for a
-- rearrangement that is being made.
CREATE FUNCTION enfilade.follow_redirect(site text, map text, OUT map_id text, OUT x double precision,
    OUT y double precision, OUT yaw double precision) RETURNS SETOF record LANGUAGE plpgsql AS $$
DECLARE
  target text;
BEGIN
  SELECT m.redirect_map_id INTO target FROM enfilade.maps m WHERE m.site_id = site AND m.map_id = map FOR KEY SHARE;
  IF target IS NOT NULL THEN RETURN QUERY SELECT * FROM enfilade.resolve_map(site, map); END IF;
END $$;

CREATE FUNCTION enfilade.redirect_session() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  r record;
BEGIN
  FOR r IN SELECT * FROM enfilade.follow_redirect(NEW.site_id, NEW.map_id) LOOP
    NEW.map_id := r.map_id;
    NEW.initial_covariance := enfilade.rotate_covariance(NEW.initial_covariance, r.yaw);
    SELECT r.x + cos(r.yaw) * NEW.initial_x - sin(r.yaw) * NEW.initial_y,
        r.y + sin(r.yaw) * NEW.initial_x + cos(r.yaw) * NEW.initial_y, enfilade.wrap_angle(NEW.initial_yaw + r.yaw)
      INTO NEW.initial_x, NEW.initial_y, NEW.initial_yaw;
  END LOOP;
  RETURN NEW;
END $$;
CREATE TRIGGER sessions_redirect BEFORE INSERT OR UPDATE OF map_id ON enfilade.sessions
  FOR EACH ROW WHEN (NEW.map_id IS NOT NULL) EXECUTE FUNCTION enfilade.redirect_session();

CREATE FUNCTION enfilade.redirect_robot_pose() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  r record;
BEGIN
  FOR r IN SELECT * FROM enfilade.follow_redirect(NEW.site_id, NEW.map_id) LOOP
    NEW.map_id := r.map_id;
    NEW.point := ST_Affine(NEW.point, cos(r.yaw), -sin(r.yaw), sin(r.yaw), cos(r.yaw), r.x, r.y);
    NEW.yaw := enfilade.wrap_angle(NEW.yaw + r.yaw);
    NEW.covariance := enfilade.rotate_covariance(NEW.covariance, r.yaw);
  END LOOP;
  RETURN NEW;
END $$;
CREATE TRIGGER robot_poses_redirect BEFORE INSERT ON enfilade.robot_poses
  FOR EACH ROW EXECUTE FUNCTION enfilade.redirect_robot_pose();

CREATE FUNCTION enfilade.redirect_control_point() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  r record;
BEGIN
  FOR r IN SELECT * FROM enfilade.follow_redirect(NEW.site_id, NEW.map_id) LOOP
    NEW.map_id := r.map_id;
    SELECT r.x + cos(r.yaw) * NEW.x - sin(r.yaw) * NEW.y, r.y + sin(r.yaw) * NEW.x + cos(r.yaw) * NEW.y
      INTO NEW.x, NEW.y;
  END LOOP;
  RETURN NEW;
END $$;
CREATE TRIGGER control_points_redirect BEFORE INSERT ON enfilade.control_points
  FOR EACH ROW EXECUTE FUNCTION enfilade.redirect_control_point();

-- An anchor belongs to a frame that its author knows: it is not moved, but refused.
CREATE FUNCTION enfilade.refuse_redirected_anchor() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  PERFORM FROM enfilade.follow_redirect(NEW.site_id, NEW.map_id);
  IF FOUND THEN
    RAISE EXCEPTION USING ERRCODE = 'foreign_key_violation', CONSTRAINT = 'link_point_anchors_site_id_map_id_fkey',
      TABLE = 'link_point_anchors', SCHEMA = 'enfilade', MESSAGE = format('map %s was merged into another', NEW.map_id);
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER link_point_anchors_redirected BEFORE INSERT OR UPDATE OF map_id ON enfilade.link_point_anchors
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_redirected_anchor();

ALTER TABLE enfilade.site_graphs DROP CONSTRAINT site_graphs_cause_check,
  ADD CONSTRAINT site_graphs_cause_check CHECK (cause BETWEEN 1 AND 9);

-- As before, but a rearrangement raises the version itself, once.
CREATE OR REPLACE FUNCTION enfilade.add_map_to_graph() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  version bigint;
  root boolean;
BEGIN
  IF coalesce(current_setting('enfilade.rearranging', true), '') <> '' THEN
    INSERT INTO enfilade.graph_maps (site_id, map_id, changed_version)
      SELECT site_id, NEW.map_id, graph_version FROM enfilade.site_graphs WHERE site_id = NEW.site_id;
    RETURN NULL;
  END IF;
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

-- As before, but what a rearrangement stores again is not new.
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
    PERFORM enfilade.refuse_redundant_link_point(changed.site_id, changed.link_point_id,
      TG_OP = 'INSERT' AND coalesce(current_setting('enfilade.rearranging', true), '') = '');
  END IF;
  RETURN NULL;
END $$;

CREATE TABLE enfilade.rearrangements (
  site_id          enfilade.resource_id NOT NULL REFERENCES enfilade.sites,
  rearrangement_id enfilade.resource_id NOT NULL,
  reason           text NOT NULL,
  actor            text NOT NULL DEFAULT coalesce(current_setting('enfilade.actor', true), ''),
  version_before   bigint NOT NULL,  -- of the site's graph
  version_after    bigint NOT NULL,
  version_undone   bigint NOT NULL DEFAULT 0,  -- 0: not undone
  create_time      timestamptz NOT NULL DEFAULT now(),
  undo_time        timestamptz,
  PRIMARY KEY (site_id, rearrangement_id),
  CONSTRAINT rearrangements_undo_check CHECK ((version_undone = 0) = (undo_time IS NULL))
);
CREATE INDEX rearrangements_newest_idx ON enfilade.rearrangements (site_id, version_after);

-- What a rearrangement does. It keeps the names of what has been deleted since.
CREATE TABLE enfilade.rearrangement_parts (
  site_id          enfilade.resource_id NOT NULL,
  rearrangement_id enfilade.resource_id NOT NULL,
  kind             smallint NOT NULL,  -- 1 new map, 2 cut, 3 moved session, 4 stored, 5 removed link point, 6 redirect
  subject          enfilade.resource_id NOT NULL,  -- the map, session or link point
  source           enfilade.resource_id,  -- of a moved session: the map that it left; of a redirect: the subject
  target           enfilade.resource_id,  -- the map that it is in now; of a cut: the session with the rest
  first_sequence   bigint,                -- of a cut
  x                double precision,      -- T_target_source: m, m, rad
  y                double precision,
  yaw              double precision,
  ordinal          integer NOT NULL,
  PRIMARY KEY (site_id, rearrangement_id, kind, subject),
  FOREIGN KEY (site_id, rearrangement_id) REFERENCES enfilade.rearrangements ON DELETE CASCADE,
  CONSTRAINT rearrangement_parts_kind_check CHECK (kind BETWEEN 1 AND 6)
);

-- The inverse as data: everything that a rearrangement has changed, as it was before and as it was then
-- (rearrangement_image). NULL: it did not exist.
CREATE TABLE enfilade.rearrangement_images (
  site_id          enfilade.resource_id NOT NULL,
  rearrangement_id enfilade.resource_id NOT NULL,
  relation         text NOT NULL,
  key              text NOT NULL,
  before           jsonb,
  after            jsonb,
  PRIMARY KEY (site_id, rearrangement_id, relation, key),
  FOREIGN KEY (site_id, rearrangement_id) REFERENCES enfilade.rearrangements ON DELETE CASCADE
);
ALTER TABLE enfilade.rearrangement_images ALTER COLUMN before SET COMPRESSION lz4, ALTER COLUMN after SET COMPRESSION lz4;

-- The blobs that undoing needs.
CREATE TABLE enfilade.rearrangement_blobs (
  site_id          enfilade.resource_id NOT NULL,
  rearrangement_id enfilade.resource_id NOT NULL,
  sha256           enfilade.sha256_digest NOT NULL,
  PRIMARY KEY (site_id, rearrangement_id, sha256),
  FOREIGN KEY (site_id, rearrangement_id) REFERENCES enfilade.rearrangements ON DELETE CASCADE,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs
);
CREATE INDEX rearrangement_blobs_blob_idx ON enfilade.rearrangement_blobs (site_id, sha256);

-- The present state of what a rearrangement changes, without what changes by itself (versions, places in the world,
-- what the optimisation switches off). NULL: there is none.
CREATE FUNCTION enfilade.rearrangement_image(site text, relation text, key text) RETURNS jsonb LANGUAGE plpgsql STABLE AS $$
DECLARE
  image jsonb;
BEGIN
  CASE relation
    WHEN 'map' THEN
      SELECT jsonb_build_object('level', level, 'environment', environment, 'redirect_map_id', redirect_map_id,
          'redirect_x', redirect_x, 'redirect_y', redirect_y, 'redirect_yaw', redirect_yaw,
          'raster', (SELECT r.content_sha256 FROM enfilade.map_revisions r
            WHERE r.site_id = m.site_id AND r.map_id = m.map_id AND r.revision = m.current_revision))
        INTO image FROM enfilade.maps m WHERE m.site_id = site AND m.map_id = key;
    WHEN 'layers' THEN  -- by map
      SELECT jsonb_agg(to_jsonb(l) - 'version' || jsonb_build_object('tiles', (
          SELECT coalesce(jsonb_agg(jsonb_build_object('tile_row', t.tile_row, 'tile_column', t.tile_column,
            'sha256', t.sha256) ORDER BY t.tile_row, t.tile_column), '[]')
          FROM enfilade.map_layer_tiles t
          WHERE t.site_id = l.site_id AND t.map_id = l.map_id AND t.position = l.position)) ORDER BY l.position)
        INTO image FROM enfilade.map_layers l WHERE l.site_id = site AND l.map_id = key;
    WHEN 'session' THEN
      SELECT jsonb_build_object('map_id', map_id, 'state', state, 'initial_x', initial_x, 'initial_y', initial_y,
          'initial_yaw', initial_yaw, 'initial_covariance', initial_covariance,
          'acknowledged_sequence', acknowledged_sequence, 'highest_sequence', highest_sequence,
          'recorded_sequence', recorded_sequence, 'laser_scans', laser_scans, 'odometry', odometry, 'images', images,
          'point_clouds', point_clouds, 'withheld', withheld, 'door_reports', door_reports,
          'payload_bytes', payload_bytes, 'last_time_ns', last_time_ns,
          'checkpoint', (SELECT jsonb_build_object('mapped_sequence', c.mapped_sequence, 'used', c.used,
              'keyframes', c.keyframes) FROM enfilade.mapping_checkpoints c
            WHERE c.site_id = s.site_id AND c.session_id = s.session_id))
        INTO image FROM enfilade.sessions s WHERE s.site_id = site AND s.session_id = key AND s.delete_time IS NULL;
    WHEN 'closures' THEN  -- by session
      SELECT jsonb_agg(to_jsonb(c) ORDER BY c.closure_id) INTO image FROM enfilade.slam_closures c
        WHERE c.site_id = site AND c.session_id = key;
    WHEN 'slam' THEN  -- by session
      SELECT jsonb_build_object(
          'submaps', (SELECT jsonb_agg(jsonb_build_object('i', submap_id, 'v', version, 'x', x, 'y', y, 't', yaw)
              ORDER BY submap_id)
            FROM enfilade.slam_submaps m WHERE m.site_id = site AND m.session_id = key),
          'nodes', (SELECT jsonb_agg(jsonb_build_object('i', node_id, 'x', x, 'y', y, 't', yaw, 'c', covariance)
              ORDER BY node_id)
            FROM enfilade.slam_nodes n WHERE n.site_id = site AND n.session_id = key),
          'track', (SELECT jsonb_build_object('map_id', map_id, 'track', track::text)
            FROM enfilade.session_tracks t WHERE t.site_id = site AND t.session_id = key))
        INTO image;
    WHEN 'verdict' THEN  -- by session/sequence
      SELECT jsonb_build_object('map_id', map_id, 'link_point_id', link_point_id, 'x', x, 'y', y, 'yaw', yaw,
          'covariance', covariance)
        INTO image FROM enfilade.door_verdicts v WHERE v.site_id = site
          AND v.session_id = split_part(key, '/', 1) AND v.sequence = split_part(key, '/', 2)::bigint;
    WHEN 'link_point' THEN
      SELECT jsonb_build_object('link_point', to_jsonb(p) - 'position' - 'yaw' - 'world_covariance' - 'changed_version'
            - 'etag' - 'update_time' - 'levels' - 'anchor_count'
            || jsonb_build_object('use', CASE "use" WHEN 2 THEN 1 ELSE "use" END),
          'anchors', (SELECT jsonb_agg(to_jsonb(a) ORDER BY a.ordinal) FROM enfilade.link_point_anchors a
            WHERE a.site_id = site AND a.link_point_id = key),
          'evidence', (SELECT jsonb_agg(to_jsonb(e) ORDER BY e.map_id, e.kind, e.ordinal)
            FROM enfilade.link_point_evidence e WHERE e.site_id = site AND e.link_point_id = key))
        INTO image FROM enfilade.link_points p WHERE p.site_id = site AND p.link_point_id = key;
    WHEN 'control_points' THEN  -- of the site
      SELECT jsonb_agg(to_jsonb(c) ORDER BY c.ordinal) INTO image FROM enfilade.control_points c WHERE c.site_id = site;
    WHEN 'robot_pose' THEN
      SELECT to_jsonb(p) - 'point' || jsonb_build_object('point', p.point::text)
        INTO image FROM enfilade.robot_poses p WHERE p.site_id = site AND p.robot_id = key;
    WHEN 'place' THEN  -- of a map in the world
      SELECT jsonb_build_object('x', x, 'y', y, 'yaw', yaw, 'covariance', covariance)
        INTO image FROM enfilade.graph_maps g WHERE g.site_id = site AND g.map_id = key;
  END CASE;
  RETURN image;
END $$;

COMMIT;
