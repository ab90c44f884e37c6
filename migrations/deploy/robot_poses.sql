-- SPDX-License-Identifier: Apache-2.0
-- The poses that robots report, and the poses at which sessions enter an existing map.
BEGIN;

ALTER TABLE enfilade.sessions
  ADD COLUMN initial_x double precision,  -- T_map_robot at the first scan: m, m, rad; NULL: the map starts with it
  ADD COLUMN initial_y double precision,
  ADD COLUMN initial_yaw double precision,
  ADD CONSTRAINT sessions_initial_pose_check CHECK (
    num_nulls(initial_x, initial_y, initial_yaw) IN (0, 3)
    AND initial_x > '-Infinity' AND initial_x < 'Infinity' AND initial_y > '-Infinity' AND initial_y < 'Infinity'
    AND initial_yaw > '-Infinity' AND initial_yaw < 'Infinity');

-- The last one of each robot.
CREATE TABLE enfilade.robot_poses (
  site_id    enfilade.resource_id NOT NULL,
  robot_id   enfilade.resource_id NOT NULL,
  map_id     enfilade.resource_id NOT NULL,
  session_id enfilade.resource_id,          -- that it was reported in
  point      geometry(PointM, 0) NOT NULL,  -- m, in the map's frame; M: the time in seconds since 1970
  yaw        double precision NOT NULL,     -- rad
  covariance double precision[] NOT NULL CHECK (cardinality(covariance) = 9),  -- of (x, y, yaw), row by row
  time_ns    bigint NOT NULL,               -- since 1970, by the robot's clock
  version    bigint NOT NULL DEFAULT nextval('enfilade.etags'),  -- a new one with every report
  PRIMARY KEY (site_id, robot_id),
  FOREIGN KEY (site_id, robot_id) REFERENCES enfilade.robots ON DELETE CASCADE,
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE
) WITH (fillfactor = 50);
CREATE INDEX robot_poses_point_idx ON enfilade.robot_poses USING gist (site_id, map_id, point);

COMMIT;
