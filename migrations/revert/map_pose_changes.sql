-- SPDX-License-Identifier: Apache-2.0
-- Keeps the poses of the last optimisation only, all of them in its version.
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'map_pose_changes';
CREATE TEMP TABLE last_poses ON COMMIT DROP AS
  SELECT p.site_id, v.version, p.map_id, p.x, p.y, p.yaw, p.covariance
  FROM (SELECT DISTINCT ON (site_id, map_id) * FROM enfilade.map_poses ORDER BY site_id, map_id, version DESC) p
  JOIN (SELECT site_id, max(version) AS version FROM enfilade.graph_versions WHERE cause = 7 GROUP BY site_id) v
    USING (site_id)
  WHERE p.x IS NOT NULL;
TRUNCATE enfilade.map_poses;
DROP INDEX enfilade.map_poses_of_map_idx;
INSERT INTO enfilade.map_poses SELECT site_id, version, map_id, x, y, yaw, covariance FROM last_poses;
ALTER TABLE enfilade.map_poses
  DROP CONSTRAINT map_poses_whole,
  ALTER x SET NOT NULL,
  ALTER y SET NOT NULL,
  ALTER yaw SET NOT NULL,
  ALTER covariance SET NOT NULL,
  ADD CONSTRAINT map_poses_site_id_version_fkey FOREIGN KEY (site_id, version) REFERENCES enfilade.graph_versions
    ON DELETE CASCADE;

COMMIT;
