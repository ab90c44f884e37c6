-- SPDX-License-Identifier: Apache-2.0
-- The sequence goes on behind the versions that are there.
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'robot_pose_order';
LOCK TABLE enfilade.robot_poses IN SHARE ROW EXCLUSIVE MODE;
SELECT setval('enfilade.etags', greatest((SELECT max(version) FROM enfilade.robot_poses),
  (SELECT last_value FROM enfilade.etags)));
ALTER TABLE enfilade.robot_poses ALTER version SET DEFAULT nextval('enfilade.etags');

COMMIT;
