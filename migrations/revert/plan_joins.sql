-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'plan_joins';

DROP INDEX enfilade.rearrangements_plan_joins_idx;
ALTER TABLE enfilade.rearrangements DROP COLUMN plan_withdrawn, DROP COLUMN prior_map_id;
COMMIT;
