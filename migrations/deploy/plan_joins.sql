-- SPDX-License-Identifier: Apache-2.0
-- A door of a plan joins two maps whose robots have seen it from both of its sides: a rearrangement of link points.
BEGIN;

-- prior_map_id: the plan; NULL: it is no such rearrangement. plan_withdrawn: it was undone because the plan is no longer
-- in use, not by people.
ALTER TABLE enfilade.rearrangements
  ADD COLUMN prior_map_id text COLLATE "C",
  ADD COLUMN plan_withdrawn boolean NOT NULL DEFAULT false;
CREATE INDEX rearrangements_plan_joins_idx ON enfilade.rearrangements (site_id) WHERE prior_map_id IS NOT NULL;

INSERT INTO enfilade.schema_compatibility VALUES ('plan_joins', 'pins');
COMMIT;
