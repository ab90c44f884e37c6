-- SPDX-License-Identifier: Apache-2.0
-- Ids of the audit trail that grow with time on every node: a sequence goes backwards when a shard moves to a node whose
-- range of numbers is lower.
BEGIN;

-- Microseconds since 2020, and 12 bits of a sequence, which tell rows of one microsecond apart. Enough until 2091.
CREATE FUNCTION enfilade.time_ordered_id() RETURNS bigint LANGUAGE sql VOLATILE AS $$
  SELECT ((extract(epoch FROM clock_timestamp()) - 1577836800) * 1e6)::bigint * 4096
    + nextval('enfilade.audit_ids') % 4096
$$;
ALTER TABLE enfilade.audit_log ALTER audit_id SET DEFAULT enfilade.time_ordered_id();
INSERT INTO enfilade.schema_compatibility VALUES ('audit_order', 'schema_compatibility');

COMMIT;
