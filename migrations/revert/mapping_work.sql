-- SPDX-License-Identifier: Apache-2.0
DROP INDEX CONCURRENTLY IF EXISTS enfilade.sessions_to_map_idx;
CREATE INDEX CONCURRENTLY sessions_to_map_idx ON enfilade.sessions (site_id, session_id)
  WHERE map_id IS NOT NULL AND state IN (1, 2);

BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'mapping_work';
DROP TABLE enfilade.mapping_work;

COMMIT;
