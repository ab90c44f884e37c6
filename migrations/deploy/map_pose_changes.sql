-- SPDX-License-Identifier: Apache-2.0
-- An optimisation stores the poses that it changes, not all of them: a pose holds until the next row of its map. Each
-- statement is a transaction, and the script can be repeated: the index is built without a long lock.

ALTER TABLE enfilade.map_poses
  DROP CONSTRAINT IF EXISTS map_poses_site_id_version_fkey,  -- rows outlive the version that wrote them
  ALTER x DROP NOT NULL,                                     -- NULL: from this version on the map has no pose
  ALTER y DROP NOT NULL,
  ALTER yaw DROP NOT NULL,
  ALTER covariance DROP NOT NULL;
ALTER TABLE enfilade.map_poses DROP CONSTRAINT IF EXISTS map_poses_whole;
ALTER TABLE enfilade.map_poses
  ADD CONSTRAINT map_poses_whole CHECK (num_nulls(x, y, yaw, covariance) IN (0, 4)) NOT VALID;
ALTER TABLE enfilade.map_poses VALIDATE CONSTRAINT map_poses_whole;
CREATE INDEX CONCURRENTLY IF NOT EXISTS map_poses_of_map_idx ON enfilade.map_poses (site_id, map_id, version);
INSERT INTO enfilade.schema_compatibility VALUES ('map_pose_changes', 'map_pose_changes') ON CONFLICT DO NOTHING;
