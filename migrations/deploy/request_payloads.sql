-- SPDX-License-Identifier: Apache-2.0
-- A request id that is used again for something else is refused. request_sha256: of all that the creation asked for; NULL:
-- not known, the creation is from before.
BEGIN;

ALTER TABLE enfilade.sites ADD COLUMN request_sha256 enfilade.sha256_digest;
ALTER TABLE enfilade.robots ADD COLUMN request_sha256 enfilade.sha256_digest;
ALTER TABLE enfilade.maps ADD COLUMN request_sha256 enfilade.sha256_digest;
ALTER TABLE enfilade.sessions ADD COLUMN request_sha256 enfilade.sha256_digest;
ALTER TABLE enfilade.link_points ADD COLUMN request_sha256 enfilade.sha256_digest;
INSERT INTO enfilade.schema_compatibility VALUES ('request_payloads', 'site_deletion');

COMMIT;
