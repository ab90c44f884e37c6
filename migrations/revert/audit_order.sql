-- SPDX-License-Identifier: Apache-2.0
-- The sequence goes on behind the ids that are there.
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'audit_order';
LOCK TABLE enfilade.audit_log IN SHARE ROW EXCLUSIVE MODE;
SELECT setval('enfilade.audit_ids', greatest((SELECT max(audit_id) FROM enfilade.audit_log),
  (SELECT last_value FROM enfilade.audit_ids)));
ALTER TABLE enfilade.audit_log ALTER audit_id SET DEFAULT nextval('enfilade.audit_ids');
DROP FUNCTION enfilade.time_ordered_id;

COMMIT;
