-- SPDX-License-Identifier: Apache-2.0
SELECT display_name, author, base_edit_version, resolution, origin_x, origin_y, origin_yaw, head, next_sequence,
  active_edits, create_time, etag, publish_time, edit_version, revision, message FROM enfilade.map_drafts WHERE false;
SELECT sequence, edit_id, author, head, active, instruction, invisible, shape, create_time FROM enfilade.map_edits
  WHERE false;
SELECT edit_version, first_version, resolution, origin_x, origin_y, origin_yaw, evidence_header
  FROM enfilade.map_overlays WHERE false;
SELECT part, tile_row, tile_column, sha256 FROM enfilade.map_overlay_tiles WHERE false;
SELECT r.edit_version, l.edit_version FROM enfilade.map_revisions r, enfilade.map_layers l WHERE false;
