-- SPDX-License-Identifier: Apache-2.0
-- Names that lead to revisions of maps. Revisions can also be edited or restored ones. Each statement up to BEGIN is a
-- transaction, and they can be repeated.

ALTER TABLE enfilade.map_revisions DROP CONSTRAINT IF EXISTS map_revisions_source_check;
ALTER TABLE enfilade.map_revisions ADD CONSTRAINT map_revisions_source_check
  CHECK (source IN (1, 2, 3, 4)) NOT VALID;  -- mapping, import, edit, restored
ALTER TABLE enfilade.map_revisions VALIDATE CONSTRAINT map_revisions_source_check;
CREATE OR REPLACE TRIGGER map_revisions_import_audit AFTER INSERT ON enfilade.map_revisions
  FOR EACH ROW WHEN (NEW.source <> 1)
  EXECUTE FUNCTION enfilade.audit('maps/%s/revisions/%s', 'map_id', 'revision');

BEGIN;

-- An alias keeps the revision that it names, and the one before, to which it can be led back.
CREATE TABLE enfilade.map_aliases (
  site_id           text COLLATE "C" NOT NULL,
  map_id            enfilade.resource_id NOT NULL,
  alias_id          enfilade.resource_id NOT NULL,
  revision          bigint NOT NULL,
  previous_revision bigint,  -- NULL: it has never led elsewhere
  actor             text NOT NULL,  -- who moved it last, as the caller said
  etag              bigint NOT NULL DEFAULT nextval('enfilade.etags'),
  update_time       timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (site_id, map_id, alias_id),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE,
  CONSTRAINT map_aliases_revision_fkey FOREIGN KEY (site_id, map_id, revision) REFERENCES enfilade.map_revisions,
  CONSTRAINT map_aliases_previous_revision_fkey FOREIGN KEY (site_id, map_id, previous_revision)
    REFERENCES enfilade.map_revisions,
  CONSTRAINT map_aliases_previous_check CHECK (previous_revision <> revision)
);
CREATE TRIGGER map_aliases_deleted_site BEFORE INSERT ON enfilade.map_aliases
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_in_deleted_site();
CREATE TRIGGER map_aliases_audit AFTER INSERT OR UPDATE OR DELETE ON enfilade.map_aliases
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('maps/%s/aliases/%s', 'map_id', 'alias_id');

INSERT INTO enfilade.schema_compatibility VALUES ('map_aliases', 'map_aliases');
COMMIT;
