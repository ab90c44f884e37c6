-- SPDX-License-Identifier: Apache-2.0
-- Who changed what, when, and how it was before: written in the transaction of the change, append-only. It outlives
-- its site.
BEGIN;

CREATE SEQUENCE enfilade.audit_ids;
CREATE TABLE enfilade.audit_log (
  site_id  enfilade.resource_id NOT NULL,
  audit_id bigint NOT NULL DEFAULT nextval('enfilade.audit_ids'),
  time     timestamptz NOT NULL DEFAULT now(),
  actor    text NOT NULL,  -- as the caller said; '' if it said nothing
  action   smallint NOT NULL CHECK (action IN (1, 2, 3)),  -- created, updated, deleted
  resource text NOT NULL,  -- maps/{map}, linkPoints/{link_point}/anchors/{map}
  before   jsonb,
  after    jsonb,
  PRIMARY KEY (site_id, audit_id),
  CONSTRAINT audit_log_rows_check CHECK ((action = 1) = (before IS NULL) AND (action = 3) = (after IS NULL))
);
CREATE INDEX audit_log_resource_idx ON enfilade.audit_log (site_id, resource text_pattern_ops, audit_id);

CREATE FUNCTION enfilade.refuse_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  RAISE EXCEPTION USING ERRCODE = 'restrict_violation', MESSAGE = 'the audit trail is never changed';
END $$;
CREATE TRIGGER audit_log_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON enfilade.audit_log
  FOR EACH STATEMENT EXECUTE FUNCTION enfilade.refuse_change();

-- Arguments: the format of the resource, such as 'linkPoints/%s/anchors/%s', and its columns.
CREATE FUNCTION enfilade.audit() RETURNS trigger LANGUAGE plpgsql AS $$
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

-- Only columns that people write; revisions and solutions of the graph have their own history.
CREATE TRIGGER maps_audit
  AFTER INSERT OR UPDATE OF display_name, level, environment, slam_profile, outline OR DELETE ON enfilade.maps
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('maps/%s', 'map_id');
CREATE TRIGGER link_points_audit
  AFTER INSERT OR UPDATE OF kind, tag, direction_map_id, difficulty, environment, state, valid_until, "use", forced
  OR DELETE ON enfilade.link_points
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('linkPoints/%s', 'link_point_id');
CREATE TRIGGER link_point_anchors_audit
  AFTER INSERT OR UPDATE OR DELETE ON enfilade.link_point_anchors
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('linkPoints/%s/anchors/%s', 'link_point_id', 'map_id');
CREATE TRIGGER link_point_evidence_audit
  AFTER INSERT OR UPDATE OR DELETE ON enfilade.link_point_evidence
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('linkPoints/%s/evidence/%s/%s', 'link_point_id', 'map_id', 'kind');
CREATE TRIGGER control_points_audit
  AFTER INSERT OR UPDATE OR DELETE ON enfilade.control_points
  FOR EACH ROW EXECUTE FUNCTION enfilade.audit('controlPoints/%s', 'ordinal');

COMMIT;
