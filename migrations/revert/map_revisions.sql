-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TABLE enfilade.map_revision_tiles;
DROP TABLE enfilade.map_revisions;

COMMIT;
