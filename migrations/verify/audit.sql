-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT site_id, audit_id, time, actor, action, resource, before, after FROM enfilade.audit_log WHERE false;
SELECT 1 / (count(*) / 6) FROM pg_trigger
WHERE tgname IN ('audit_log_append_only', 'maps_audit', 'link_points_audit', 'link_point_anchors_audit',
  'link_point_evidence_audit', 'control_points_audit');

ROLLBACK;
