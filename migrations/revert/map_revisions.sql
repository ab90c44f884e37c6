BEGIN;

DROP TABLE enfilade.map_revision_tiles;
DROP TABLE enfilade.map_revisions;

COMMIT;
