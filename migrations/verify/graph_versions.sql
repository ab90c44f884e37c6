-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, version, cause, resource, actor, create_time, chi2_before, chi2_after, switched_off, map_count,
  residual_count
FROM enfilade.graph_versions WHERE false;
SELECT site_id, version, map_id, x, y, yaw, covariance FROM enfilade.map_poses WHERE false;
SELECT site_id, ordinal, map_id, x, y, latitude, longitude FROM enfilade.control_points WHERE false;
SELECT 1 / count(*) FROM pg_trigger WHERE tgname = 'site_graphs_record';

ROLLBACK;
