-- SPDX-License-Identifier: Apache-2.0
-- A site whose deletion is not done stays with what it still has, and can be deleted again.
BEGIN;

DROP TRIGGER robots_deleted_site ON enfilade.robots;
DROP TRIGGER maps_deleted_site ON enfilade.maps;
DROP TRIGGER sessions_deleted_site ON enfilade.sessions;
DROP FUNCTION enfilade.refuse_in_deleted_site();
ALTER TABLE enfilade.sites DROP COLUMN deleted_rows, DROP COLUMN deletion_step, DROP COLUMN delete_actor,
  DROP COLUMN delete_time;

COMMIT;
