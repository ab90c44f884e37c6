-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TABLE enfilade.robot_poses;
ALTER TABLE enfilade.sessions
  DROP CONSTRAINT sessions_initial_pose_check,
  DROP COLUMN initial_x,
  DROP COLUMN initial_y,
  DROP COLUMN initial_yaw;

COMMIT;
