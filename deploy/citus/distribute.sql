-- SPDX-License-Identifier: Apache-2.0
-- Distributes all tables of a migrated database by site, over the nodes of a Citus cluster (docs/database.md). Run it
-- once, with psql, as the owner of the tables, on the coordinator; the extension and the nodes must be there. Small
-- tables whose rows do not belong to a site are on every node.
\set ON_ERROR_STOP on
BEGIN;

SELECT 1 / count(*) FROM pg_extension WHERE extname = 'citus';
-- Triggers write to rows of the same site only, which are on the same node.
SET LOCAL citus.enable_unsafe_triggers = on;
SELECT create_reference_table('enfilade.schema_compatibility');
SELECT create_reference_table('enfilade.site_requests');
SELECT create_distributed_table('enfilade.sites', 'site_id', colocate_with => 'none');

-- The others follow in an order that foreign keys permit: a table comes after those that it refers to.
DO $$
DECLARE
  next regclass;
BEGIN
  LOOP
    SELECT t.oid INTO next FROM pg_class t
      WHERE t.relnamespace = 'enfilade'::regnamespace AND t.relkind = 'r'
        AND NOT EXISTS (SELECT FROM pg_dist_partition d WHERE d.logicalrelid = t.oid)
        AND NOT EXISTS (SELECT FROM pg_constraint c WHERE c.conrelid = t.oid AND c.contype = 'f'
          AND c.confrelid <> t.oid AND NOT EXISTS (
            SELECT FROM pg_dist_partition d WHERE d.logicalrelid = c.confrelid))
      ORDER BY t.relname LIMIT 1;
    EXIT WHEN next IS NULL;
    PERFORM create_distributed_table(next::text, 'site_id', colocate_with => 'enfilade.sites');
  END LOOP;
END $$;
SELECT 1 / (1 - count(*)) FROM pg_class t
  WHERE t.relnamespace = 'enfilade'::regnamespace AND t.relkind = 'r'
    AND NOT EXISTS (SELECT FROM pg_dist_partition d WHERE d.logicalrelid = t.oid);

-- The actor and the rearrangement, which triggers read, reach the nodes by SET LOCAL.
DO $$
BEGIN
  EXECUTE format('ALTER DATABASE %I SET citus.propagate_set_commands = ''local''', current_database());
END $$;

COMMIT;
