-- SPDX-License-Identifier: Apache-2.0
-- A request id that is used again for something else is refused. request_sha256: of all that the creation asked for; NULL:
-- not known, the creation is from before. A column of the domain sha256_digest would have each row written anew. Each
-- statement is a transaction, and the script can be repeated.

ALTER TABLE enfilade.sites ADD COLUMN IF NOT EXISTS request_sha256 bytea;
ALTER TABLE enfilade.sites DROP CONSTRAINT IF EXISTS sites_request_sha256_check;
ALTER TABLE enfilade.sites ADD CONSTRAINT sites_request_sha256_check CHECK (octet_length(request_sha256) = 32) NOT VALID;
ALTER TABLE enfilade.sites VALIDATE CONSTRAINT sites_request_sha256_check;
ALTER TABLE enfilade.robots ADD COLUMN IF NOT EXISTS request_sha256 bytea;
ALTER TABLE enfilade.robots DROP CONSTRAINT IF EXISTS robots_request_sha256_check;
ALTER TABLE enfilade.robots ADD CONSTRAINT robots_request_sha256_check CHECK (octet_length(request_sha256) = 32) NOT VALID;
ALTER TABLE enfilade.robots VALIDATE CONSTRAINT robots_request_sha256_check;
ALTER TABLE enfilade.maps ADD COLUMN IF NOT EXISTS request_sha256 bytea;
ALTER TABLE enfilade.maps DROP CONSTRAINT IF EXISTS maps_request_sha256_check;
ALTER TABLE enfilade.maps ADD CONSTRAINT maps_request_sha256_check CHECK (octet_length(request_sha256) = 32) NOT VALID;
ALTER TABLE enfilade.maps VALIDATE CONSTRAINT maps_request_sha256_check;
ALTER TABLE enfilade.sessions ADD COLUMN IF NOT EXISTS request_sha256 bytea;
ALTER TABLE enfilade.sessions DROP CONSTRAINT IF EXISTS sessions_request_sha256_check;
ALTER TABLE enfilade.sessions ADD CONSTRAINT sessions_request_sha256_check CHECK (octet_length(request_sha256) = 32) NOT VALID;
ALTER TABLE enfilade.sessions VALIDATE CONSTRAINT sessions_request_sha256_check;
ALTER TABLE enfilade.link_points ADD COLUMN IF NOT EXISTS request_sha256 bytea;
ALTER TABLE enfilade.link_points DROP CONSTRAINT IF EXISTS link_points_request_sha256_check;
ALTER TABLE enfilade.link_points ADD CONSTRAINT link_points_request_sha256_check CHECK (octet_length(request_sha256) = 32) NOT VALID;
ALTER TABLE enfilade.link_points VALIDATE CONSTRAINT link_points_request_sha256_check;
INSERT INTO enfilade.schema_compatibility VALUES ('request_payloads', 'site_deletion') ON CONFLICT DO NOTHING;
