-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT previous_session_id, initial_covariance, initial_odom_x, initial_odom_y, initial_odom_yaw, door_reports
FROM enfilade.sessions WHERE false;

ROLLBACK;
