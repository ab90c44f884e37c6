-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT 1 / (count(*) = 0)::integer FROM information_schema.columns
WHERE table_schema = 'enfilade' AND column_name = 'site_id' AND domain_name IS NOT NULL;

ROLLBACK;
