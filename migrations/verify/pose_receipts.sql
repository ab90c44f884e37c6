-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT received_ns FROM enfilade.robot_poses WHERE false;

ROLLBACK;
