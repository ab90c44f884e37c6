-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'request_payloads';
ALTER TABLE enfilade.sites DROP COLUMN request_sha256;
ALTER TABLE enfilade.robots DROP COLUMN request_sha256;
ALTER TABLE enfilade.maps DROP COLUMN request_sha256;
ALTER TABLE enfilade.sessions DROP COLUMN request_sha256;
ALTER TABLE enfilade.link_points DROP COLUMN request_sha256;

COMMIT;
