-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'map_aliases';
DROP TABLE IF EXISTS enfilade.map_aliases;
CREATE OR REPLACE TRIGGER map_revisions_import_audit AFTER INSERT ON enfilade.map_revisions
  FOR EACH ROW WHEN (NEW.source = 2)
  EXECUTE FUNCTION enfilade.audit('maps/%s/revisions/%s', 'map_id', 'revision');
COMMIT;

-- Edited and restored revisions look like imports to the program before.
UPDATE enfilade.map_revisions SET source = 2 WHERE source > 2;
ALTER TABLE enfilade.map_revisions DROP CONSTRAINT IF EXISTS map_revisions_source_check;
ALTER TABLE enfilade.map_revisions ADD CONSTRAINT map_revisions_source_check CHECK (source IN (1, 2)) NOT VALID;
ALTER TABLE enfilade.map_revisions VALIDATE CONSTRAINT map_revisions_source_check;
