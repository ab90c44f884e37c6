-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TABLE enfilade.image_features;
DELETE FROM enfilade.link_point_evidence WHERE ordinal > 1;
ALTER TABLE enfilade.link_point_evidence
  DROP CONSTRAINT link_point_evidence_pkey,
  DROP CONSTRAINT link_point_evidence_pose_check,
  DROP COLUMN ordinal,
  DROP COLUMN x,
  DROP COLUMN y,
  DROP COLUMN yaw,
  ADD PRIMARY KEY (site_id, link_point_id, map_id, kind);
DROP TABLE enfilade.door_comparisons;
DROP TABLE enfilade.door_verdicts;
DROP INDEX enfilade.sessions_waiting_idx;
DROP INDEX enfilade.sessions_doors_to_judge_idx;
ALTER TABLE enfilade.sessions DROP COLUMN doors_judged;
DROP TABLE enfilade.site_leases;

COMMIT;
