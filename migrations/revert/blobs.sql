BEGIN;

DROP TABLE enfilade.blobs;

COMMIT;
