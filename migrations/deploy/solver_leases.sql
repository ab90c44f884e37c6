-- SPDX-License-Identifier: Apache-2.0
-- The right to solve a site's graph, apart from the right to change it: judging a door does not wait for a solution.
BEGIN;

CREATE TABLE enfilade.solver_leases (
  site_id    text COLLATE "C" PRIMARY KEY REFERENCES enfilade.sites ON DELETE CASCADE,
  owner      text NOT NULL,
  token      bigint NOT NULL CHECK (token >= 1),
  expires_at timestamptz NOT NULL
) WITH (fillfactor = 50);
INSERT INTO enfilade.schema_compatibility VALUES ('solver_leases', 'robot_pose_order');

COMMIT;
