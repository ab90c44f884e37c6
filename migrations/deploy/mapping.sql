-- SPDX-License-Identifier: Apache-2.0
-- The results of mapping a session's log, and the leases for it.
BEGIN;

-- The row stays when the lease is released: tokens only increase.
CREATE TABLE enfilade.session_leases (
  site_id    enfilade.resource_id NOT NULL,
  session_id enfilade.resource_id NOT NULL,
  owner      text NOT NULL,
  token      bigint NOT NULL CHECK (token >= 1),
  expires_at timestamptz NOT NULL,
  PRIMARY KEY (site_id, session_id),
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions
) WITH (fillfactor = 50);

CREATE TABLE enfilade.mapping_checkpoints (
  site_id         enfilade.resource_id NOT NULL,
  session_id      enfilade.resource_id NOT NULL,
  mapped_sequence bigint NOT NULL CHECK (mapped_sequence >= 0),
  token           bigint NOT NULL,  -- of the lease under which it was written
  paired          bigint NOT NULL,
  unpaired        bigint NOT NULL,
  time_reversed   bigint NOT NULL,
  used            bigint NOT NULL,
  keyframes       bigint NOT NULL,
  lost            bigint NOT NULL,
  state           bytea NOT NULL,  -- the pairing's and the mapper's
  PRIMARY KEY (site_id, session_id),
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions
);
ALTER TABLE enfilade.mapping_checkpoints ALTER COLUMN state SET COMPRESSION lz4;

CREATE TABLE enfilade.slam_submaps (
  site_id    enfilade.resource_id NOT NULL,
  session_id enfilade.resource_id NOT NULL,
  submap_id  bigint NOT NULL CHECK (submap_id >= 0),
  version    bigint NOT NULL,
  x          double precision NOT NULL,  -- T_map_submap: m, m, rad
  y          double precision NOT NULL,
  yaw        double precision NOT NULL,
  finished   boolean NOT NULL,
  content    bytea NOT NULL,  -- compressed; empty until finished
  PRIMARY KEY (site_id, session_id, submap_id),
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions
) WITH (fillfactor = 70);
ALTER TABLE enfilade.slam_submaps ALTER COLUMN content SET STORAGE EXTERNAL;

CREATE TABLE enfilade.slam_nodes (
  site_id    enfilade.resource_id NOT NULL,
  session_id enfilade.resource_id NOT NULL,
  node_id    bigint NOT NULL CHECK (node_id >= 0),
  sequence   bigint NOT NULL,
  time_ns    bigint NOT NULL,
  x          double precision NOT NULL,  -- T_map_node: m, m, rad
  y          double precision NOT NULL,
  yaw        double precision NOT NULL,
  covariance double precision[] NOT NULL CHECK (cardinality(covariance) = 9),  -- of (x, y, yaw), row by row
  submap_id  bigint NOT NULL,
  PRIMARY KEY (site_id, session_id, node_id),
  FOREIGN KEY (site_id, session_id, submap_id) REFERENCES enfilade.slam_submaps
) WITH (fillfactor = 70);  -- poses move when the graph is solved

CREATE TABLE enfilade.slam_closures (
  site_id     enfilade.resource_id NOT NULL,
  session_id  enfilade.resource_id NOT NULL,
  closure_id  bigint NOT NULL CHECK (closure_id >= 0),
  submap_id   bigint NOT NULL,
  node_id     bigint NOT NULL,
  x           double precision NOT NULL,  -- T_submap_node: m, m, rad
  y           double precision NOT NULL,
  yaw         double precision NOT NULL,
  information double precision[] NOT NULL CHECK (cardinality(information) = 9),
  state       smallint NOT NULL,
  score       double precision NOT NULL,
  chi2        double precision NOT NULL,
  reason      text NOT NULL,
  PRIMARY KEY (site_id, session_id, closure_id),
  FOREIGN KEY (site_id, session_id, submap_id) REFERENCES enfilade.slam_submaps,
  FOREIGN KEY (site_id, session_id, node_id) REFERENCES enfilade.slam_nodes,
  CONSTRAINT slam_closures_state_check CHECK (state IN (1, 2, 3))  -- accepted, rejected, suspended
);

-- One row per mapped scan, relative to a keyframe so that it remains correct when keyframes move.
CREATE TABLE enfilade.trajectory_points (
  site_id    enfilade.resource_id NOT NULL,
  session_id enfilade.resource_id NOT NULL,
  sequence   bigint NOT NULL,
  time_ns    bigint NOT NULL,
  node_id    bigint NOT NULL,
  x          double precision NOT NULL,  -- T_node_robot: m, m, rad
  y          double precision NOT NULL,
  yaw        double precision NOT NULL,
  PRIMARY KEY (site_id, session_id, sequence),
  FOREIGN KEY (site_id, session_id, node_id) REFERENCES enfilade.slam_nodes
);

-- The robot's track by its keyframes; M is the time in seconds since 1970. Updated with each revision.
CREATE TABLE enfilade.session_tracks (
  site_id    enfilade.resource_id NOT NULL,
  session_id enfilade.resource_id NOT NULL,
  map_id     enfilade.resource_id NOT NULL,
  track      geometry(LineStringM, 0) NOT NULL,  -- m, in the map's frame
  PRIMARY KEY (site_id, session_id),
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions,
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE
);
CREATE INDEX session_tracks_track_idx ON enfilade.session_tracks USING gist (site_id, map_id, track);

COMMIT;
