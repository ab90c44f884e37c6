-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT 'enfilade.trajectory_points_node_idx'::regclass;

ROLLBACK;
