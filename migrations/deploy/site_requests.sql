-- SPDX-License-Identifier: Apache-2.0
-- The creations of sites by request id, in a table of their own: one that is on every node of a sharded database, as a
-- unique key of the sites that lacks site_id cannot be.
BEGIN;

CREATE TABLE enfilade.site_requests (
  request_id  text COLLATE "C" PRIMARY KEY,  -- of the call that created the site (AIP-155)
  site_id     text COLLATE "C" NOT NULL,
  create_time timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX site_requests_site_idx ON enfilade.site_requests (site_id);
INSERT INTO enfilade.site_requests (request_id, site_id)
  SELECT request_id, site_id FROM enfilade.sites WHERE request_id IS NOT NULL;
ALTER TABLE enfilade.sites DROP CONSTRAINT sites_request_id_key;
INSERT INTO enfilade.schema_compatibility VALUES ('site_requests', 'site_requests');

COMMIT;
