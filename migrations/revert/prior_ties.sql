-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'prior_ties';
DELETE FROM enfilade.prior_map_files WHERE product = 6;
ALTER TABLE enfilade.prior_maps DROP COLUMN tied_walls, DROP COLUMN joined_maps;
UPDATE enfilade.site_graphs SET cause = 7, resource = '' WHERE cause = 10;
COMMIT;

ALTER TABLE enfilade.prior_map_files DROP CONSTRAINT IF EXISTS prior_map_files_product_check;
ALTER TABLE enfilade.prior_map_files ADD CONSTRAINT prior_map_files_product_check
  CHECK (product BETWEEN 1 AND 5) NOT VALID;
ALTER TABLE enfilade.prior_map_files VALIDATE CONSTRAINT prior_map_files_product_check;
ALTER TABLE enfilade.site_graphs DROP CONSTRAINT IF EXISTS site_graphs_cause_check;
ALTER TABLE enfilade.site_graphs ADD CONSTRAINT site_graphs_cause_check CHECK (cause BETWEEN 1 AND 9) NOT VALID;
ALTER TABLE enfilade.site_graphs VALIDATE CONSTRAINT site_graphs_cause_check;
