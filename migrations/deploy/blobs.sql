-- SPDX-License-Identifier: Apache-2.0
-- Content-addressed bytes: images, point clouds, tiles of rasters.
BEGIN;

CREATE TABLE enfilade.blobs (
  site_id  enfilade.resource_id NOT NULL REFERENCES enfilade.sites,
  sha256   enfilade.sha256_digest NOT NULL,
  size     bigint GENERATED ALWAYS AS (octet_length(data)) STORED,
  put_time timestamptz NOT NULL DEFAULT now(),  -- the last time: recent blobs are not collected
  data     bytea NOT NULL,
  PRIMARY KEY (site_id, sha256),
  CONSTRAINT blobs_size_check CHECK (octet_length(data) BETWEEN 1 AND 67108864)
);

-- The content is already compressed.
ALTER TABLE enfilade.blobs ALTER COLUMN data SET STORAGE EXTERNAL;

COMMIT;
