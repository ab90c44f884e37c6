-- SPDX-License-Identifier: Apache-2.0
-- The cause of each version of a site's graph, and the poses of its maps after each optimisation.
BEGIN;

CREATE TABLE enfilade.graph_versions (
  site_id      enfilade.resource_id NOT NULL,
  version      bigint NOT NULL,
  cause        smallint NOT NULL,   -- storage/graph/graph_store.h
  resource     text NOT NULL,
  actor        text NOT NULL,       -- who changed it, as the caller said; '' if it said nothing
  create_time  timestamptz NOT NULL DEFAULT now(),
  -- Of optimisations only.
  chi2_before  double precision,
  chi2_after   double precision,
  switched_off text[],              -- ids of link points
  map_count    bigint,
  residual_count bigint,
  PRIMARY KEY (site_id, version),
  FOREIGN KEY (site_id) REFERENCES enfilade.site_graphs ON DELETE CASCADE
);
CREATE INDEX graph_versions_optimisations_idx ON enfilade.graph_versions (site_id, version) WHERE cause = 7;

CREATE FUNCTION enfilade.record_graph_version() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO enfilade.graph_versions (site_id, version, cause, resource, actor)
    VALUES (NEW.site_id, NEW.graph_version, NEW.cause, NEW.resource,
      coalesce(current_setting('enfilade.actor', true), ''));
  RETURN NULL;
END $$;
INSERT INTO enfilade.graph_versions (site_id, version, cause, resource, actor)
  SELECT site_id, graph_version, cause, resource, '' FROM enfilade.site_graphs;
CREATE TRIGGER site_graphs_record AFTER INSERT OR UPDATE OF graph_version ON enfilade.site_graphs
  FOR EACH ROW EXECUTE FUNCTION enfilade.record_graph_version();

-- Keeps the poses of maps that have been deleted since.
CREATE TABLE enfilade.map_poses (
  site_id    enfilade.resource_id NOT NULL,
  version    bigint NOT NULL,
  map_id     enfilade.resource_id NOT NULL,
  x          double precision NOT NULL,    -- T_world_map: m, m, rad
  y          double precision NOT NULL,
  yaw        double precision NOT NULL,
  covariance double precision[] NOT NULL CHECK (cardinality(covariance) = 9),  -- of (x, y, yaw), row by row
  PRIMARY KEY (site_id, version, map_id),
  FOREIGN KEY (site_id, version) REFERENCES enfilade.graph_versions ON DELETE CASCADE
);

-- Places with known coordinates on the globe: a georeference is fitted to them.
CREATE TABLE enfilade.control_points (
  site_id   enfilade.resource_id NOT NULL REFERENCES enfilade.sites,
  ordinal   integer NOT NULL,
  map_id    enfilade.resource_id NOT NULL,
  x         double precision NOT NULL,  -- m, in the map's frame
  y         double precision NOT NULL,
  latitude  double precision NOT NULL CHECK (latitude BETWEEN -90 AND 90),    -- WGS 84, degrees
  longitude double precision NOT NULL CHECK (longitude BETWEEN -180 AND 180),
  PRIMARY KEY (site_id, ordinal),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE,
  CONSTRAINT control_points_position_check CHECK (
    x > '-Infinity' AND x < 'Infinity' AND y > '-Infinity' AND y < 'Infinity')
);

COMMIT;
