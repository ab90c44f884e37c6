-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP INDEX enfilade.session_records_doors_idx;
ALTER TABLE enfilade.sessions DROP CONSTRAINT sessions_count_check;
-- The door reports stay in the log. They count as withheld, so that the counts still cover it.
UPDATE enfilade.sessions SET withheld = withheld + door_reports WHERE door_reports > 0;
ALTER TABLE enfilade.sessions
  DROP COLUMN previous_session_id,
  DROP COLUMN initial_covariance,
  DROP COLUMN initial_odom_x,
  DROP COLUMN initial_odom_y,
  DROP COLUMN initial_odom_yaw,
  DROP COLUMN door_reports,
  ADD CONSTRAINT sessions_count_check CHECK (
    laser_scans >= 0 AND odometry >= 0 AND images >= 0 AND point_clouds >= 0 AND withheld >= 0 AND payload_bytes >= 0
    AND laser_scans + odometry + images + point_clouds + withheld BETWEEN acknowledged_sequence AND highest_sequence);

COMMIT;
