-- SPDX-License-Identifier: Apache-2.0
-- How a session's robot entered its map, and the doors that it reports.

-- For the few door reports among a session's many records.
SET lock_timeout = 0;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.session_records_doors_idx;
CREATE INDEX CONCURRENTLY session_records_doors_idx ON enfilade.session_records (site_id, session_id, sequence)
  WHERE kind = 6;
RESET lock_timeout;

BEGIN;

ALTER TABLE enfilade.sessions
  -- The session that ends with the passage into this one. map_id is NULL until the passage is judged.
  ADD COLUMN previous_session_id text COLLATE "C",
  ADD COLUMN initial_covariance double precision[],  -- of initial_x, _y, _yaw; 9 numbers, row by row
  ADD COLUMN initial_odom_x double precision,  -- T_odom_robot at the initial pose: m, m, rad; NULL: of the first scan
  ADD COLUMN initial_odom_y double precision,
  ADD COLUMN initial_odom_yaw double precision,
  ADD COLUMN door_reports bigint NOT NULL DEFAULT 0,
  DROP CONSTRAINT sessions_count_check;

-- Poses from before have no covariance: 1 m and 15 deg.
UPDATE enfilade.sessions SET initial_covariance = ARRAY[1, 0, 0, 0, 1, 0, 0, 0, 0.07]::double precision[]
  WHERE initial_x IS NOT NULL;
-- Reverting counts door reports as withheld.
UPDATE enfilade.sessions s SET door_reports = d.count, withheld = s.withheld - d.count
  FROM (SELECT site_id, session_id, count(*) AS count FROM enfilade.session_records WHERE kind = 6 GROUP BY 1, 2) d
  WHERE s.site_id = d.site_id AND s.session_id = d.session_id;

ALTER TABLE enfilade.sessions
  ADD FOREIGN KEY (site_id, previous_session_id) REFERENCES enfilade.sessions,
  ADD CONSTRAINT sessions_initial_covariance_check CHECK (
    (initial_covariance IS NULL) = (initial_x IS NULL) AND cardinality(initial_covariance) = 9),
  ADD CONSTRAINT sessions_initial_odom_check CHECK (
    num_nulls(initial_odom_x, initial_odom_y, initial_odom_yaw) IN (0, 3)
    AND initial_odom_x > '-Infinity' AND initial_odom_x < 'Infinity'
    AND initial_odom_y > '-Infinity' AND initial_odom_y < 'Infinity'
    AND initial_odom_yaw > '-Infinity' AND initial_odom_yaw < 'Infinity'),
  ADD CONSTRAINT sessions_count_check CHECK (
    laser_scans >= 0 AND odometry >= 0 AND images >= 0 AND point_clouds >= 0 AND withheld >= 0 AND door_reports >= 0
    AND payload_bytes >= 0
    AND laser_scans + odometry + images + point_clouds + withheld + door_reports
        BETWEEN acknowledged_sequence AND highest_sequence);

CREATE INDEX sessions_previous_idx ON enfilade.sessions (site_id, previous_session_id)
  WHERE previous_session_id IS NOT NULL;

COMMIT;
