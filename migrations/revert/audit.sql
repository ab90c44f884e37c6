-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TRIGGER control_points_audit ON enfilade.control_points;
DROP TRIGGER link_point_evidence_audit ON enfilade.link_point_evidence;
DROP TRIGGER link_point_anchors_audit ON enfilade.link_point_anchors;
DROP TRIGGER link_points_audit ON enfilade.link_points;
DROP TRIGGER maps_audit ON enfilade.maps;
DROP TABLE enfilade.audit_log;
DROP SEQUENCE enfilade.audit_ids;
DROP FUNCTION enfilade.audit;
DROP FUNCTION enfilade.refuse_change;

COMMIT;
