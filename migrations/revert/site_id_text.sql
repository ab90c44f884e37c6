-- SPDX-License-Identifier: Apache-2.0
-- The columns stay text, which suits older programs as well: making them domains again would rewrite all tables under lock.
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'site_id_text';
ALTER TABLE enfilade.sites DROP CONSTRAINT sites_site_id_check;

COMMIT;
