-- SPDX-License-Identifier: Apache-2.0
-- Verdicts on robots' door reports, the leases for judging them, and the features that they are judged by.
BEGIN;

-- The right to judge a site's doors or to solve its graph. The row stays when the lease is released.
CREATE TABLE enfilade.site_leases (
  site_id    enfilade.resource_id PRIMARY KEY REFERENCES enfilade.sites,
  owner      text NOT NULL,
  token      bigint NOT NULL CHECK (token >= 1),
  expires_at timestamptz NOT NULL
) WITH (fillfactor = 50);

ALTER TABLE enfilade.sessions ADD COLUMN doors_judged boolean NOT NULL DEFAULT false;
CREATE INDEX sessions_doors_to_judge_idx ON enfilade.sessions (site_id, session_id)
  WHERE door_reports > 0 AND NOT doors_judged AND state IN (3, 4);
CREATE INDEX sessions_waiting_idx ON enfilade.sessions (site_id, previous_session_id)
  WHERE previous_session_id IS NOT NULL AND map_id IS NULL AND delete_time IS NULL;

-- Keeps the names of link points and maps that have been deleted since.
CREATE TABLE enfilade.door_verdicts (
  site_id       enfilade.resource_id NOT NULL,
  session_id    enfilade.resource_id NOT NULL,
  sequence      bigint NOT NULL,    -- of the report's record
  decision      smallint NOT NULL,  -- core/closure/door_verdict.h
  link_point_id enfilade.resource_id,
  map_id        enfilade.resource_id,  -- of a passage: the map that was entered
  x             double precision,      -- T_map_robot in it: m, m, rad
  y             double precision,
  yaw           double precision,
  covariance    double precision[],
  odom_x        double precision,      -- T_odom_robot at that moment: m, m, rad
  odom_y        double precision,
  odom_yaw      double precision,
  evidence      bigint[] NOT NULL,     -- sequences of the session's records that were compared
  reason        text NOT NULL,
  graph_version bigint NOT NULL,       -- that it was judged by
  create_time   timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, session_id, sequence),
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions,
  CONSTRAINT door_verdicts_decision_check CHECK (decision BETWEEN 1 AND 6),
  CONSTRAINT door_verdicts_pose_check CHECK (
    num_nulls(x, y, yaw, covariance) IN (0, 4) AND cardinality(covariance) = 9
    AND num_nulls(odom_x, odom_y, odom_yaw) IN (0, 3))
);

CREATE TABLE enfilade.door_comparisons (
  site_id       enfilade.resource_id NOT NULL,
  session_id    enfilade.resource_id NOT NULL,
  sequence      bigint NOT NULL,
  ordinal       integer NOT NULL,    -- 1: the best
  link_point_id enfilade.resource_id NOT NULL,
  map_id        enfilade.resource_id NOT NULL,  -- where the robot would be
  distance      double precision,    -- m, by the graph; NULL: no link points lead there
  image_matches integer,             -- NULL: no images
  images_agree  boolean NOT NULL,
  rmse          double precision,    -- m; NULL: not registered
  inlier_share  double precision NOT NULL,
  clouds_agree  boolean NOT NULL,
  chi2          double precision,    -- NULL: nothing predicts the pose
  accepted      boolean NOT NULL,
  reason        text NOT NULL,
  PRIMARY KEY (site_id, session_id, sequence, ordinal),
  FOREIGN KEY (site_id, session_id, sequence) REFERENCES enfilade.door_verdicts ON DELETE CASCADE
);

-- A series of images of each camera, with the poses of the robot in the map.
ALTER TABLE enfilade.link_point_evidence
  ADD COLUMN ordinal integer NOT NULL DEFAULT 1 CHECK (ordinal >= 1),  -- 1: nearest to the door's moment
  ADD COLUMN x double precision,  -- T_map_robot: m, m, rad; NULL: not known, as at the anchor
  ADD COLUMN y double precision,
  ADD COLUMN yaw double precision,
  ADD CONSTRAINT link_point_evidence_pose_check CHECK (
    num_nulls(x, y, yaw) IN (0, 3) AND x > '-Infinity' AND x < 'Infinity' AND y > '-Infinity' AND y < 'Infinity'
    AND yaw > '-Infinity' AND yaw < 'Infinity'),
  DROP CONSTRAINT link_point_evidence_pkey,
  ADD PRIMARY KEY (site_id, link_point_id, map_id, kind, ordinal);

-- Features of a stored image (perception/image/feature_codec.h), deleted with the image.
CREATE TABLE enfilade.image_features (
  site_id  enfilade.resource_id NOT NULL,
  sha256   enfilade.sha256_digest NOT NULL,
  features bytea NOT NULL,
  PRIMARY KEY (site_id, sha256),
  FOREIGN KEY (site_id, sha256) REFERENCES enfilade.blobs ON DELETE CASCADE
);
ALTER TABLE enfilade.image_features ALTER COLUMN features SET STORAGE EXTERNAL;

COMMIT;
