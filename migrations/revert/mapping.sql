-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TABLE enfilade.session_tracks;
DROP TABLE enfilade.trajectory_points;
DROP TABLE enfilade.slam_closures;
DROP TABLE enfilade.slam_nodes;
DROP TABLE enfilade.slam_submaps;
DROP TABLE enfilade.mapping_checkpoints;
DROP TABLE enfilade.session_leases;

COMMIT;
