-- SPDX-License-Identifier: Apache-2.0
-- Which programs may serve a schema that is newer than they are. Each later change of sqitch.plan adds its row. A program
-- that does not know a change serves the schema only if it knows `oldest_program`.
BEGIN;

CREATE TABLE enfilade.schema_compatibility (
  change         text COLLATE "C" PRIMARY KEY,  -- of sqitch.plan
  oldest_program text COLLATE "C" NOT NULL      -- the last change that the oldest such program knows; `change`: breaks all older ones
);
INSERT INTO enfilade.schema_compatibility VALUES ('schema_compatibility', 'site_deletion');

COMMIT;
