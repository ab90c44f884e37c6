-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP INDEX enfilade.trajectory_points_node_idx;

COMMIT;
