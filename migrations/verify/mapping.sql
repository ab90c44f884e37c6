-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, session_id, owner, token, expires_at FROM enfilade.session_leases WHERE false;
SELECT site_id, session_id, mapped_sequence, token, paired, unpaired, time_reversed, used, keyframes, lost,
  state
FROM enfilade.mapping_checkpoints WHERE false;
SELECT site_id, session_id, submap_id, version, x, y, yaw, finished, content FROM enfilade.slam_submaps WHERE false;
SELECT site_id, session_id, node_id, sequence, time_ns, x, y, yaw, covariance, submap_id
FROM enfilade.slam_nodes WHERE false;
SELECT site_id, session_id, closure_id, submap_id, node_id, x, y, yaw, information, state, score, chi2, reason
FROM enfilade.slam_closures WHERE false;
SELECT site_id, session_id, sequence, time_ns, node_id, x, y, yaw FROM enfilade.trajectory_points WHERE false;
SELECT site_id, session_id, map_id, track FROM enfilade.session_tracks WHERE false;
SELECT 1 / count(*) FROM pg_indexes WHERE schemaname = 'enfilade' AND indexname = 'session_tracks_track_idx';

ROLLBACK;
