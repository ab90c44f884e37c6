-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, graph_version, root_map_id, cause, resource FROM enfilade.site_graphs WHERE false;
SELECT site_id, map_id, changed_version, x, y, yaw, covariance FROM enfilade.graph_maps WHERE false;
SELECT site_id, link_point_id, kind, tag, direction_map_id, difficulty, environment, state, valid_until, "use", forced,
  anchor_count, levels, position, yaw, world_covariance, changed_version, etag, request_id, create_time, update_time
FROM enfilade.link_points WHERE false;
SELECT site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance FROM enfilade.link_point_anchors WHERE false;
SELECT site_id, link_point_id, map_id, kind, encoding, sha256, time_ns FROM enfilade.link_point_evidence WHERE false;
SELECT site_id, kind, id, removed_version FROM enfilade.graph_removals WHERE false;
SELECT 1 / count(*) FROM pg_indexes WHERE schemaname = 'enfilade' AND indexname = 'link_points_position_idx';
SELECT 1 / count(*) FROM pg_trigger WHERE tgname = 'link_point_anchors_follow';
SELECT 1 / count(*) FROM pg_trigger WHERE tgname = 'maps_join_graph';

ROLLBACK;
