-- SPDX-License-Identifier: Apache-2.0
BEGIN;

ALTER TABLE enfilade.robot_poses DROP COLUMN received_ns;

COMMIT;
