BEGIN;

DROP TABLE enfilade.maps;

COMMIT;
