-- SPDX-License-Identifier: Apache-2.0
-- Bounds retention to 100 years of 365 days: longer ones overflow the database's times.
BEGIN;

UPDATE enfilade.sites SET raw_retention_s = 3153600000 WHERE raw_retention_s > 3153600000;
ALTER TABLE enfilade.sites ADD CONSTRAINT sites_raw_retention_max CHECK (raw_retention_s <= 3153600000);

COMMIT;
