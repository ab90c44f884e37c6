-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT redirect_map_id, redirect_x, redirect_y, redirect_yaw FROM enfilade.maps WHERE false;
SELECT site_id, rearrangement_id, reason, actor, version_before, version_after, version_undone, create_time, undo_time
  FROM enfilade.rearrangements WHERE false;
SELECT site_id, rearrangement_id, kind, subject, source, target, first_sequence, x, y, yaw, ordinal
  FROM enfilade.rearrangement_parts WHERE false;
SELECT site_id, rearrangement_id, relation, key, before, after FROM enfilade.rearrangement_images WHERE false;
SELECT site_id, rearrangement_id, sha256 FROM enfilade.rearrangement_blobs WHERE false;
SELECT has_function_privilege('enfilade.rearrangement_image(text, text, text)', 'execute');
SELECT has_function_privilege('enfilade.resolve_map(text, text)', 'execute');

ROLLBACK;
