-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT postgis_version();
SELECT 'a'::enfilade.resource_id, 'a'::enfilade.display_name, sha256('a')::enfilade.sha256_digest;
SELECT last_value FROM enfilade.etags;

ROLLBACK;
