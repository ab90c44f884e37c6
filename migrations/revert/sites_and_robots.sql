BEGIN;

DROP TABLE enfilade.robots;
DROP TABLE enfilade.sites;

COMMIT;
