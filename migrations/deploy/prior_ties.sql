-- SPDX-License-Identifier: Apache-2.0
-- Plans tie maps to one another. Each statement up to BEGIN is a transaction, and they can be repeated.

ALTER TABLE enfilade.prior_map_files DROP CONSTRAINT IF EXISTS prior_map_files_product_check;
ALTER TABLE enfilade.prior_map_files ADD CONSTRAINT prior_map_files_product_check
  CHECK (product BETWEEN 1 AND 6) NOT VALID;  -- sheet, plan, corrected, planning, picture, ties
ALTER TABLE enfilade.prior_map_files VALIDATE CONSTRAINT prior_map_files_product_check;
ALTER TABLE enfilade.site_graphs DROP CONSTRAINT IF EXISTS site_graphs_cause_check;
ALTER TABLE enfilade.site_graphs ADD CONSTRAINT site_graphs_cause_check CHECK (cause BETWEEN 1 AND 10) NOT VALID;
ALTER TABLE enfilade.site_graphs VALIDATE CONSTRAINT site_graphs_cause_check;

BEGIN;

-- Of the last alignment that was accepted.
ALTER TABLE enfilade.prior_maps
  ADD COLUMN tied_walls  integer,  -- how often a map has seen a wall of the plan; NULL: it was aligned before this
  ADD COLUMN joined_maps text[];   -- those that no link points joined to the root then

INSERT INTO enfilade.schema_compatibility VALUES ('prior_ties', 'prior_ties');
COMMIT;
