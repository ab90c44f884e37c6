-- SPDX-License-Identifier: Apache-2.0
-- The extensions stay: they may have been there before, and other schemas may use them.
BEGIN;

DROP SEQUENCE enfilade.etags;
DROP DOMAIN enfilade.sha256_digest;
DROP DOMAIN enfilade.display_name;
DROP DOMAIN enfilade.resource_id;
DROP SCHEMA enfilade;

COMMIT;
