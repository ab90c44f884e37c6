-- SPDX-License-Identifier: Apache-2.0
-- The schema, its extensions, and the types that all tables share.
BEGIN;

-- A role without the right to create them finds them there already: the administrator has created them.
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

-- Etags: one number for every version of every row, never given twice, so that a row deleted and made again under its
-- old id does not match an old etag.
CREATE SEQUENCE enfilade.etags;

COMMIT;
