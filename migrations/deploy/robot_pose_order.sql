-- SPDX-License-Identifier: Apache-2.0
-- Versions of robots' poses that grow with time on every node, as the ids of the audit trail do.
BEGIN;

ALTER TABLE enfilade.robot_poses ALTER version SET DEFAULT enfilade.time_ordered_id();
INSERT INTO enfilade.schema_compatibility VALUES ('robot_pose_order', 'loose_blobs');

COMMIT;
