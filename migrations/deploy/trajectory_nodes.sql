-- SPDX-License-Identifier: Apache-2.0
-- Deleting keyframes looks for the trajectory's points that refer to them.

SET lock_timeout = 0;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.trajectory_points_node_idx;
CREATE INDEX CONCURRENTLY trajectory_points_node_idx ON enfilade.trajectory_points (site_id, session_id, node_id);
