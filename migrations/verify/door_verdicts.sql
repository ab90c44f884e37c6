-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, owner, token, expires_at FROM enfilade.site_leases WHERE false;
SELECT doors_judged FROM enfilade.sessions WHERE false;
SELECT session_id, sequence, decision, link_point_id, map_id, x, y, yaw, covariance, odom_x, odom_y, odom_yaw, evidence,
  reason, graph_version, create_time
FROM enfilade.door_verdicts WHERE false;
SELECT ordinal, link_point_id, map_id, distance, image_matches, images_agree, rmse, inlier_share, clouds_agree, chi2,
  accepted, reason
FROM enfilade.door_comparisons WHERE false;
SELECT ordinal, x, y, yaw FROM enfilade.link_point_evidence WHERE false;
SELECT sha256, features FROM enfilade.image_features WHERE false;

ROLLBACK;
