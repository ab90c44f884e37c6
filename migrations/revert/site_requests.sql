-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'site_requests';
ALTER TABLE enfilade.sites ADD CONSTRAINT sites_request_id_key UNIQUE (request_id);
DROP TABLE enfilade.site_requests;

COMMIT;
