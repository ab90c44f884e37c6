-- SPDX-License-Identifier: Apache-2.0
DELETE FROM enfilade.schema_compatibility WHERE change = 'retention_policies';
CREATE OR REPLACE TRIGGER audit_log_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON enfilade.audit_log
  FOR EACH STATEMENT EXECUTE FUNCTION enfilade.refuse_change();
DROP TRIGGER IF EXISTS audit_log_kept ON enfilade.audit_log;
DROP FUNCTION IF EXISTS enfilade.refuse_audit_change;
ALTER TABLE enfilade.site_graphs DROP COLUMN IF EXISTS forgotten_version;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.rearrangement_images_key_idx;
DROP TABLE IF EXISTS enfilade.revision_reviews;
ALTER TABLE enfilade.map_layers DROP CONSTRAINT IF EXISTS map_layers_site_id_map_id_revision_fkey;
ALTER TABLE enfilade.map_layers ADD CONSTRAINT map_layers_site_id_map_id_revision_fkey
  FOREIGN KEY (site_id, map_id, revision) REFERENCES enfilade.map_revisions ON DELETE CASCADE NOT VALID;
ALTER TABLE enfilade.map_layers VALIDATE CONSTRAINT map_layers_site_id_map_id_revision_fkey;
ALTER TABLE enfilade.map_layers DROP CONSTRAINT IF EXISTS map_layers_revision_fkey;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.map_layers_revision_idx;
DROP TRIGGER IF EXISTS map_revisions_tag_audit ON enfilade.map_revisions;
ALTER TABLE enfilade.map_revisions DROP COLUMN IF EXISTS tag;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.sessions_finished_idx;
CREATE OR REPLACE TRIGGER sites_change_audit AFTER UPDATE OF display_name, raw_retention_s, delete_time ON enfilade.sites
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('');
ALTER TABLE enfilade.sites
  DROP CONSTRAINT IF EXISTS sites_retentions_check,
  DROP COLUMN IF EXISTS session_retention_s, DROP COLUMN IF EXISTS revisions_kept,
  DROP COLUMN IF EXISTS revision_retention_s, DROP COLUMN IF EXISTS history_retention_s,
  DROP COLUMN IF EXISTS audit_retention_s;
