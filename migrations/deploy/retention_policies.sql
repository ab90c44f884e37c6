-- SPDX-License-Identifier: Apache-2.0
-- How long a site keeps old revisions, its sessions, the graph's history and the audit trail. Each statement is a
-- transaction, and the script can be repeated: what checks or indexes large tables does so without a long lock.

ALTER TABLE enfilade.sites  -- NULL: for ever, or all
  ADD COLUMN IF NOT EXISTS session_retention_s bigint,
  ADD COLUMN IF NOT EXISTS revisions_kept bigint,  -- of each map, the newest
  ADD COLUMN IF NOT EXISTS revision_retention_s bigint,
  ADD COLUMN IF NOT EXISTS history_retention_s bigint,
  ADD COLUMN IF NOT EXISTS audit_retention_s bigint;
ALTER TABLE enfilade.sites
  DROP CONSTRAINT IF EXISTS sites_retentions_check,
  ADD CONSTRAINT sites_retentions_check CHECK (
    coalesce(session_retention_s, 0) BETWEEN 0 AND 3153600000 AND coalesce(revision_retention_s, 0) BETWEEN 0 AND 3153600000
    AND coalesce(history_retention_s, 0) BETWEEN 0 AND 3153600000 AND coalesce(audit_retention_s, 0) BETWEEN 0 AND 3153600000
    AND coalesce(revisions_kept, 1) >= 1 AND (revisions_kept IS NOT NULL OR revision_retention_s IS NULL));
CREATE OR REPLACE TRIGGER sites_change_audit AFTER UPDATE OF display_name, raw_retention_s, session_retention_s,
  revisions_kept, revision_retention_s, history_retention_s, audit_retention_s, delete_time ON enfilade.sites
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('');
CREATE INDEX CONCURRENTLY IF NOT EXISTS sessions_finished_idx ON enfilade.sessions (site_id, finish_time)
  WHERE delete_time IS NULL AND finish_time IS NOT NULL;

-- A revision with a tag is kept.
ALTER TABLE enfilade.map_revisions ADD COLUMN IF NOT EXISTS tag text NOT NULL DEFAULT '';
ALTER TABLE enfilade.map_revisions DROP CONSTRAINT IF EXISTS map_revisions_tag_check;
ALTER TABLE enfilade.map_revisions ADD CONSTRAINT map_revisions_tag_check CHECK (char_length(tag) <= 64) NOT VALID;
ALTER TABLE enfilade.map_revisions VALIDATE CONSTRAINT map_revisions_tag_check;
CREATE OR REPLACE TRIGGER map_revisions_tag_audit AFTER UPDATE OF tag ON enfilade.map_revisions
  FOR EACH ROW WHEN (OLD.tag <> NEW.tag) EXECUTE FUNCTION enfilade.audit('maps/%s/revisions/%s', 'map_id', 'revision');

-- A layer keeps its revision.
ALTER TABLE enfilade.map_layers DROP CONSTRAINT IF EXISTS map_layers_revision_fkey;
ALTER TABLE enfilade.map_layers ADD CONSTRAINT map_layers_revision_fkey
  FOREIGN KEY (site_id, map_id, revision) REFERENCES enfilade.map_revisions NOT VALID;
ALTER TABLE enfilade.map_layers VALIDATE CONSTRAINT map_layers_revision_fkey;
ALTER TABLE enfilade.map_layers DROP CONSTRAINT IF EXISTS map_layers_site_id_map_id_revision_fkey;
CREATE INDEX CONCURRENTLY IF NOT EXISTS map_layers_revision_idx ON enfilade.map_layers (site_id, map_id, revision)
  WHERE revision IS NOT NULL;

-- When to look for revisions of a map that are past their retention. Maps that have never had two are not here.
CREATE TABLE IF NOT EXISTS enfilade.revision_reviews (
  site_id  text COLLATE "C" NOT NULL,
  map_id   enfilade.resource_id NOT NULL,
  due_time timestamptz NOT NULL,  -- 'infinity': not before there is a new revision
  PRIMARY KEY (site_id, map_id),
  FOREIGN KEY (site_id, map_id) REFERENCES enfilade.maps ON DELETE CASCADE
);
CREATE INDEX CONCURRENTLY IF NOT EXISTS revision_reviews_due_idx ON enfilade.revision_reviews (site_id, due_time);
INSERT INTO enfilade.revision_reviews SELECT site_id, map_id, now() FROM enfilade.maps WHERE current_revision > 1
  ON CONFLICT DO NOTHING;

-- Which rearrangements of a map can be undone.
CREATE INDEX CONCURRENTLY IF NOT EXISTS rearrangement_images_key_idx ON enfilade.rearrangement_images (site_id, key);

-- What was removed from the graph up to this version is no longer known.
ALTER TABLE enfilade.site_graphs ADD COLUMN IF NOT EXISTS forgotten_version bigint NOT NULL DEFAULT 0;

-- The site's retention is the only thing that deletes from the audit trail.
CREATE OR REPLACE FUNCTION enfilade.refuse_audit_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF TG_OP = 'DELETE' AND EXISTS (SELECT FROM enfilade.sites WHERE site_id = OLD.site_id
      AND OLD.time <= now() - audit_retention_s * interval '1 second') THEN
    RETURN OLD;
  END IF;
  RAISE EXCEPTION USING ERRCODE = 'restrict_violation', MESSAGE = 'the audit trail is never changed';
END $$;
CREATE OR REPLACE TRIGGER audit_log_kept BEFORE UPDATE OR DELETE ON enfilade.audit_log
  FOR EACH ROW EXECUTE FUNCTION enfilade.refuse_audit_change();
CREATE OR REPLACE TRIGGER audit_log_append_only BEFORE TRUNCATE ON enfilade.audit_log
  FOR EACH STATEMENT EXECUTE FUNCTION enfilade.refuse_change();

INSERT INTO enfilade.schema_compatibility VALUES ('retention_policies', 'robot_pose_order') ON CONFLICT DO NOTHING;
