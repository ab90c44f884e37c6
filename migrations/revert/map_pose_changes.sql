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
DROP TABLE enfilade.map_poses;
CREATE TABLE enfilade.map_poses (
  site_id    text COLLATE "C" NOT NULL,
  version    bigint NOT NULL,
  map_id     enfilade.resource_id NOT NULL,
  x          double precision NOT NULL,
  y          double precision NOT NULL,
  yaw        double precision NOT NULL,
  covariance double precision[] NOT NULL CHECK (cardinality(covariance) = 9),
  PRIMARY KEY (site_id, version, map_id),
  FOREIGN KEY (site_id, version) REFERENCES enfilade.graph_versions ON DELETE CASCADE
);
INSERT INTO enfilade.map_poses SELECT site_id, version, map_id, x, y, yaw, covariance FROM last_poses;

COMMIT;
