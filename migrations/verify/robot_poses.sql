-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT initial_x, initial_y, initial_yaw FROM enfilade.sessions WHERE false;
SELECT site_id, robot_id, map_id, session_id, point, yaw, covariance, time_ns, version
FROM enfilade.robot_poses WHERE false;

ROLLBACK;
