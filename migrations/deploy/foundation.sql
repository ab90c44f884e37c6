-- SPDX-License-Identifier: Apache-2.0
-- The schema, its extensions, and the shared types.
BEGIN;

-- If the role may not create extensions, the administrator creates them beforehand.
CREATE EXTENSION IF NOT EXISTS postgis;
CREATE EXTENSION IF NOT EXISTS btree_gist;

CREATE SCHEMA enfilade;

-- The last segment of a resource name (AIP-122), as core/base/ids.h has it.
CREATE DOMAIN enfilade.resource_id AS text COLLATE "C"
  CHECK (VALUE ~ '^[a-z0-9]([a-z0-9-]{0,61}[a-z0-9])?$');

CREATE DOMAIN enfilade.display_name AS text COLLATE "C"
  CHECK (char_length(VALUE) BETWEEN 1 AND 200);

CREATE DOMAIN enfilade.sha256_digest AS bytea
  CHECK (octet_length(VALUE) = 32);

-- Etags: a unique number for every version of every row, so that a row that was deleted and created again under its old
-- id does not match an old etag.
CREATE SEQUENCE enfilade.etags;

COMMIT;
