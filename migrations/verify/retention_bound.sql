-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT 1 / count(*) FROM pg_constraint
WHERE conrelid = 'enfilade.sites'::regclass AND conname = 'sites_raw_retention_max';

ROLLBACK;
