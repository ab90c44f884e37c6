-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT 1 / count(*) FROM pg_trigger WHERE tgname = 'map_revisions_import_audit' AND tgrelid = 'enfilade.map_revisions'::regclass;

ROLLBACK;
