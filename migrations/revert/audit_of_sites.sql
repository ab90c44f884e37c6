-- SPDX-License-Identifier: Apache-2.0
-- What the trail has stays.
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'audit_of_sites';
DROP TRIGGER map_revisions_import_audit ON enfilade.map_revisions;
DROP TRIGGER sessions_change_audit ON enfilade.sessions;
DROP TRIGGER sessions_audit ON enfilade.sessions;
DROP TRIGGER robots_audit ON enfilade.robots;
DROP TRIGGER sites_change_audit ON enfilade.sites;
DROP TRIGGER sites_audit ON enfilade.sites;
CREATE OR REPLACE FUNCTION enfilade.audit() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
  before jsonb;
  after jsonb;
  ids text[];
BEGIN
  IF TG_OP <> 'INSERT' THEN before := to_jsonb(OLD) - 'changed_version' - 'position' - 'world_covariance'; END IF;
  IF TG_OP <> 'DELETE' THEN after := to_jsonb(NEW) - 'changed_version' - 'position' - 'world_covariance'; END IF;
  SELECT array_agg(coalesce(after, before) ->> column_name ORDER BY place) INTO ids
    FROM unnest(TG_ARGV[1:]) WITH ORDINALITY AS c (column_name, place);
  INSERT INTO enfilade.audit_log (site_id, actor, action, resource, before, after)
    VALUES (coalesce(after, before) ->> 'site_id', coalesce(current_setting('enfilade.actor', true), ''),
      CASE TG_OP WHEN 'INSERT' THEN 1 WHEN 'UPDATE' THEN 2 ELSE 3 END, format(TG_ARGV[0], VARIADIC ids), before, after);
  RETURN NULL;
END $$;

COMMIT;
