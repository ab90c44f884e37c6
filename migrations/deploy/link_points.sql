-- SPDX-License-Identifier: Apache-2.0
-- The topological graph of a site: its maps, and the places where they meet.
BEGIN;

-- One row per site. Writers of the graph lock it, so that the writers of a site follow one another.
CREATE TABLE enfilade.site_graphs (
  site_id       enfilade.resource_id PRIMARY KEY REFERENCES enfilade.sites,
  graph_version bigint NOT NULL DEFAULT 0 CHECK (graph_version >= 0),  -- grows with every change of the graph
  root_map_id   enfilade.resource_id,  -- carries the world frame: its pose is fixed when the graph is solved
  cause         smallint NOT NULL,     -- of this version: storage/graph/graph_store.h
  resource      text NOT NULL,         -- that changed: maps/{map}, linkPoints/{link_point}; '' for the graph
  FOREIGN KEY (site_id, root_map_id) REFERENCES enfilade.maps,
  CONSTRAINT site_graphs_cause_check CHECK (cause BETWEEN 1 AND 8)
) WITH (fillfactor = 50);

CREATE FUNCTION enfilade.notify_graph() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  PERFORM pg_notify('enfilade_graph', NEW.site_id || ' ' || NEW.graph_version);
  RETURN NULL;
END $$;
CREATE TRIGGER site_graphs_notify AFTER UPDATE OF graph_version ON enfilade.site_graphs
  FOR EACH ROW EXECUTE FUNCTION enfilade.notify_graph();

-- Every map of the site, with its place in the world.
CREATE TABLE enfilade.graph_maps (
  site_id         enfilade.resource_id NOT NULL,
  map_id          enfilade.resource_id NOT NULL,
  changed_version bigint NOT NULL,   -- of the graph when this row or the map itself last changed
  x               double precision,  -- T_world_map: m, m, rad; NULL: never joined to the root map so far
  y               double precision,
  yaw             double precision,
  covariance      double precision[],  -- of (x, y, yaw), row by row
  PRIMARY KEY (site_id, map_id),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE,
  CONSTRAINT graph_maps_pose_check CHECK (num_nulls(x, y, yaw, covariance) IN (0, 4) AND cardinality(covariance) = 9)
) WITH (fillfactor = 70);
CREATE INDEX graph_maps_changed_idx ON enfilade.graph_maps (site_id, changed_version);

CREATE TABLE enfilade.link_points (
  site_id          enfilade.resource_id NOT NULL REFERENCES enfilade.sites,
  link_point_id    enfilade.resource_id NOT NULL,
  kind             smallint NOT NULL,
  tag              text COLLATE "C" NOT NULL DEFAULT '' CHECK (char_length(tag) <= 200),
  direction_map_id enfilade.resource_id,  -- the map that was entered when it was made
  difficulty       integer NOT NULL DEFAULT 0 CHECK (difficulty >= 0),
  environment      smallint NOT NULL DEFAULT 0,
  state            smallint NOT NULL DEFAULT 1,
  valid_until      timestamptz,  -- of the state; afterwards the place counts as open
  "use"            smallint NOT NULL DEFAULT 1,
  forced           boolean NOT NULL DEFAULT false,  -- may stand beside one that joins the same maps
  anchor_count     integer NOT NULL DEFAULT 0,      -- 1: a candidate
  levels           int4multirange NOT NULL DEFAULT '{}',  -- of the maps that it joins
  position         geometry(Point, 0),  -- m, in the world frame, as the graph was last solved; NULL: not joined to the root
  yaw              double precision,    -- of the place in the world frame, rad
  world_covariance double precision[],  -- of (x, y, yaw) in the world frame, row by row
  changed_version  bigint NOT NULL,
  etag             bigint NOT NULL DEFAULT nextval('enfilade.etags'),
  request_id       text,
  create_time      timestamptz NOT NULL DEFAULT now(),
  update_time      timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, link_point_id),
  UNIQUE (site_id, request_id),
  CONSTRAINT link_points_kind_check CHECK (kind IN (1, 2, 3, 4, 5)),         -- door, lift, stairs, ramp, opening
  CONSTRAINT link_points_environment_check CHECK (environment IN (0, 1, 2)),  -- not known, indoor, outdoor
  CONSTRAINT link_points_state_check CHECK (state IN (1, 2, 3)),             -- open, closed, blocked
  CONSTRAINT link_points_use_check CHECK ("use" IN (1, 2, 3)),               -- used, switched off, suspended
  CONSTRAINT link_points_position_check CHECK (
    num_nulls(position, yaw, world_covariance) IN (0, 3) AND cardinality(world_covariance) = 9)
) WITH (fillfactor = 70);  -- positions move when the graph is solved
CREATE INDEX link_points_position_idx ON enfilade.link_points USING gist (site_id, levels, position);
CREATE INDEX link_points_world_idx ON enfilade.link_points USING gist (site_id, position);
CREATE INDEX link_points_changed_idx ON enfilade.link_points (site_id, changed_version);
CREATE INDEX link_points_unplaced_idx ON enfilade.link_points (site_id, link_point_id) WHERE position IS NULL;

-- The place as one map sees it.
CREATE TABLE enfilade.link_point_anchors (
  site_id       enfilade.resource_id NOT NULL,
  link_point_id enfilade.resource_id NOT NULL,
  map_id        enfilade.resource_id NOT NULL,
  ordinal       integer NOT NULL,           -- the order in which they were made
  x             double precision NOT NULL,  -- T_map_place: m, m, rad
  y             double precision NOT NULL,
  yaw           double precision NOT NULL,
  covariance    double precision[] NOT NULL CHECK (cardinality(covariance) = 9),  -- of (x, y, yaw), row by row
  PRIMARY KEY (site_id, link_point_id, map_id),
  FOREIGN KEY (site_id, link_point_id) REFERENCES enfilade.link_points ON DELETE CASCADE,
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps,
  CONSTRAINT link_point_anchors_pose_check CHECK (
    x > '-Infinity' AND x < 'Infinity' AND y > '-Infinity' AND y < 'Infinity'
    AND yaw > '-Infinity' AND yaw < 'Infinity')
);
CREATE INDEX link_point_anchors_map_idx ON enfilade.link_point_anchors (site_id, map_id);

CREATE TABLE enfilade.link_point_evidence (
  site_id       enfilade.resource_id NOT NULL,
  link_point_id enfilade.resource_id NOT NULL,
  map_id        enfilade.resource_id NOT NULL,
  kind          smallint NOT NULL,
  encoding      smallint NOT NULL,  -- core/sensor/record.h: ImageEncoding or PointCloudEncoding, by the kind
  sha256        enfilade.sha256_digest NOT NULL,
  time_ns       bigint NOT NULL,    -- when it was recorded, since 1970
  PRIMARY KEY (site_id, link_point_id, map_id, kind),
  FOREIGN KEY (site_id, link_point_id, map_id) REFERENCES enfilade.link_point_anchors ON DELETE CASCADE,
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs,
  CONSTRAINT link_point_evidence_kind_check CHECK (kind IN (1, 2, 3))  -- front image, rear image, cloud
);
CREATE INDEX link_point_evidence_blob_idx ON enfilade.link_point_evidence (site_id, sha256);

-- What was removed from the graph, for those who keep a copy of it.
CREATE TABLE enfilade.graph_removals (
  site_id         enfilade.resource_id NOT NULL,
  kind            smallint NOT NULL CHECK (kind IN (1, 2)),  -- map, link point
  id              enfilade.resource_id NOT NULL,
  removed_version bigint NOT NULL,
  PRIMARY KEY (site_id, kind, id)
);
CREATE INDEX graph_removals_version_idx ON enfilade.graph_removals (site_id, removed_version);

-- How far apart two estimates of one place may lie. core/graph/same_place.h has this rule and its numbers; the stores
-- decide by it, and what follows is the last line of defence. A contract test compares both.
CREATE FUNCTION enfilade.same_place_distance(a double precision[], b double precision[]) RETURNS double precision
  LANGUAGE sql IMMUTABLE PARALLEL SAFE AS $$
  SELECT greatest(0.3, sqrt(5.991 * ((xx + yy) / 2 + sqrt(((xx - yy) / 2) ^ 2 + xy ^ 2))))
  FROM (SELECT a[1] + b[1] AS xx, a[2] + b[2] AS xy, a[5] + b[5] AS yy) s
$$;

-- Raises unique_violation if the link point joins two maps that another one joins at the same place, as seen from every
-- map that both join. As CheckNotRedundant in storage/graph/link_point_rules.h: suspended link points do not count; a forced
-- one keeps away new ones, but those that already stand beside it may be changed.
CREATE FUNCTION enfilade.refuse_redundant_link_point(site text, id text, is_new boolean) RETURNS void LANGUAGE plpgsql AS $$
DECLARE
  other record;
BEGIN
  PERFORM FROM enfilade.site_graphs WHERE site_id = site FOR UPDATE;
  SELECT o.link_point_id, count(*) AS maps, max(distance) AS distance INTO other
  FROM enfilade.link_points p
  JOIN enfilade.link_point_anchors m ON m.site_id = p.site_id AND m.link_point_id = p.link_point_id
  JOIN enfilade.link_point_anchors o
    ON o.site_id = m.site_id AND o.map_id = m.map_id AND o.link_point_id <> m.link_point_id
  CROSS JOIN LATERAL (SELECT sqrt((o.x - m.x) ^ 2 + (o.y - m.y) ^ 2) AS distance) d
  JOIN enfilade.link_points q
    ON q.site_id = o.site_id AND q.link_point_id = o.link_point_id AND q."use" <> 3 AND (is_new OR NOT q.forced)
  WHERE p.site_id = site AND p.link_point_id = id AND p."use" <> 3 AND NOT p.forced AND p.anchor_count > 1
  GROUP BY o.link_point_id
  HAVING count(*) > 1 AND bool_and(distance <= enfilade.same_place_distance(m.covariance, o.covariance))
  ORDER BY max(distance) LIMIT 1;
  IF FOUND THEN
    RAISE EXCEPTION USING ERRCODE = 'unique_violation', CONSTRAINT = 'link_points_redundant',
      TABLE = 'link_points', SCHEMA = 'enfilade',
      MESSAGE = format('it joins the same %s maps at the same place as sites/%s/linkPoints/%s, %s m apart',
        other.maps, site, other.link_point_id, round(other.distance::numeric, 2));
  END IF;
END $$;

CREATE FUNCTION enfilade.check_redundant_link_point() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  PERFORM enfilade.refuse_redundant_link_point(NEW.site_id, NEW.link_point_id, false);
  RETURN NULL;
END $$;

-- Maintains the columns that depend on the anchors, and refuses a redundant link point.
CREATE FUNCTION enfilade.follow_anchors() RETURNS trigger LANGUAGE plpgsql AS $$
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
CREATE TRIGGER link_point_anchors_follow AFTER INSERT OR UPDATE OR DELETE ON enfilade.link_point_anchors
  FOR EACH ROW EXECUTE FUNCTION enfilade.follow_anchors();
CREATE TRIGGER link_points_redundant AFTER UPDATE OF "use", forced ON enfilade.link_points
  FOR EACH ROW WHEN ((OLD."use" = 3 AND NEW."use" <> 3) OR (OLD.forced AND NOT NEW.forced))
  EXECUTE FUNCTION enfilade.check_redundant_link_point();

-- A map's new level is a new level of its link points.
CREATE FUNCTION enfilade.follow_level() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  UPDATE enfilade.link_points p SET levels = a.levels, changed_version = g.graph_version
  FROM (SELECT c.link_point_id, range_agg(int4range(m.level, m.level, '[]')) AS levels
    FROM enfilade.link_point_anchors c JOIN enfilade.maps m ON m.site_id = c.site_id AND m.map_id = c.map_id
    WHERE c.site_id = NEW.site_id AND c.link_point_id IN (SELECT link_point_id FROM enfilade.link_point_anchors
      WHERE site_id = NEW.site_id AND map_id = NEW.map_id)
    GROUP BY c.link_point_id) a, enfilade.site_graphs g
  WHERE g.site_id = NEW.site_id AND p.site_id = NEW.site_id AND p.link_point_id = a.link_point_id;
  RETURN NULL;
END $$;
CREATE TRIGGER maps_level AFTER UPDATE OF level ON enfilade.maps
  FOR EACH ROW WHEN (OLD.level <> NEW.level) EXECUTE FUNCTION enfilade.follow_level();

-- Every map is in its site's graph, and the site's first is the root.
CREATE FUNCTION enfilade.add_map_to_graph() RETURNS trigger LANGUAGE plpgsql AS $$
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
INSERT INTO enfilade.site_graphs (site_id, graph_version, root_map_id, cause, resource)
  SELECT DISTINCT ON (site_id) site_id, 1, map_id, 1, 'maps/' || map_id FROM enfilade.maps ORDER BY site_id, create_time, map_id;
INSERT INTO enfilade.graph_maps (site_id, map_id, changed_version, x, y, yaw, covariance)
  SELECT m.site_id, m.map_id, 1, root.zero, root.zero, root.zero, array_fill(root.zero, '{9}')
  FROM enfilade.maps m JOIN enfilade.site_graphs g USING (site_id)
  CROSS JOIN LATERAL (SELECT CASE WHEN g.root_map_id = m.map_id THEN 0::double precision END AS zero) root
  WHERE root.zero IS NOT NULL;
INSERT INTO enfilade.graph_maps (site_id, map_id, changed_version)
  SELECT site_id, map_id, 1 FROM enfilade.maps ON CONFLICT DO NOTHING;
CREATE TRIGGER maps_join_graph AFTER INSERT ON enfilade.maps
  FOR EACH ROW EXECUTE FUNCTION enfilade.add_map_to_graph();

COMMIT;
