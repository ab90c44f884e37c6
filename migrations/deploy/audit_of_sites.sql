-- SPDX-License-Identifier: Apache-2.0
-- The audit trail also has sites, robots, sessions and imports.
BEGIN;

-- As before, but without rasters' headers, and a row that is marked as deleted counts as deleted, whenever it goes. The
-- resource '' is the site itself.
CREATE OR REPLACE FUNCTION enfilade.audit() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  hidden CONSTANT text[] := '{changed_version,position,world_covariance,raster_header}';
  before jsonb;
  after jsonb;
  ids text[];
BEGIN
  IF TG_OP <> 'INSERT' THEN before := to_jsonb(OLD) - hidden; END IF;
  IF TG_OP <> 'DELETE' THEN after := to_jsonb(NEW) - hidden; END IF;
  SELECT array_agg(coalesce(after, before) ->> column_name ORDER BY place) INTO ids
    FROM unnest(TG_ARGV[1:]) WITH ORDINALITY AS c (column_name, place);
  IF after ->> 'delete_time' IS NOT NULL THEN after := NULL; END IF;
  INSERT INTO enfilade.audit_log (site_id, actor, action, resource, before, after)
    VALUES (coalesce(after, before) ->> 'site_id', coalesce(current_setting('enfilade.actor', true), ''),
      CASE WHEN before IS NULL THEN 1 WHEN after IS NULL THEN 3 ELSE 2 END, format(TG_ARGV[0], VARIADIC ids), before,
      after);
  RETURN NULL;
END $$;

CREATE TRIGGER sites_audit AFTER INSERT ON enfilade.sites
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('');
CREATE TRIGGER sites_change_audit AFTER UPDATE OF display_name, raw_retention_s, delete_time ON enfilade.sites
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('');
CREATE TRIGGER robots_audit AFTER INSERT OR UPDATE OR DELETE ON enfilade.robots
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('robots/%s', 'robot_id');
CREATE TRIGGER sessions_audit AFTER INSERT ON enfilade.sessions
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('sessions/%s', 'session_id');
CREATE TRIGGER sessions_change_audit AFTER UPDATE OF finish_time, records_deleted, delete_time ON enfilade.sessions
  FOR EACH ROW WHEN ((OLD.finish_time, OLD.records_deleted, OLD.delete_time) IS DISTINCT FROM
    (NEW.finish_time, NEW.records_deleted, NEW.delete_time))
  EXECUTE FUNCTION enfilade.audit('sessions/%s', 'session_id');
CREATE TRIGGER map_revisions_import_audit AFTER INSERT ON enfilade.map_revisions
  FOR EACH ROW WHEN (NEW.source = 2)
  EXECUTE FUNCTION enfilade.audit('maps/%s/revisions/%s', 'map_id', 'revision');
INSERT INTO enfilade.schema_compatibility VALUES ('audit_of_sites', 'site_deletion');

COMMIT;
