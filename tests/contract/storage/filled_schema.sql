-- SPDX-License-Identifier: Apache-2.0
-- Rows for every table, at any change of sqitch.plan: columns that are not there yet are left out. Rows that a later
-- change's reverting has to deal with are here, too.
CREATE FUNCTION pg_temp.fill(relation text, content jsonb, since text DEFAULT 'foundation', until text DEFAULT '')
  RETURNS void LANGUAGE plpgsql AS $$
DECLARE
  columns text;
BEGIN
  content := '{"site_id": "a"}' || content;
  IF to_regclass('enfilade.' || relation) IS NULL
      OR NOT EXISTS (SELECT FROM sqitch.changes WHERE change = since)
      OR EXISTS (SELECT FROM sqitch.changes WHERE change = until) THEN
    RETURN;
  END IF;
  SELECT string_agg(quote_ident(attname), ', ') INTO columns FROM pg_attribute
    WHERE attrelid = to_regclass('enfilade.' || relation) AND attnum > 0 AND NOT attisdropped AND content ? attname;
  EXECUTE format('INSERT INTO enfilade.%I (%s) SELECT %s FROM jsonb_populate_record(NULL::enfilade.%I, $1)'
    ' ON CONFLICT DO NOTHING', relation, columns, columns, relation) USING content;
END $$;
CREATE FUNCTION pg_temp.alter(statement text, since text) RETURNS void LANGUAGE plpgsql AS $$
BEGIN
  IF EXISTS (SELECT FROM sqitch.changes WHERE change = since) THEN EXECUTE statement; END IF;
END $$;
CREATE FUNCTION pg_temp.hash(digit text) RETURNS text LANGUAGE sql AS $$ SELECT '\x' || repeat(digit, 64) $$;
CREATE FUNCTION pg_temp.identity() RETURNS jsonb LANGUAGE sql AS $$ SELECT '[1, 0, 0, 0, 1, 0, 0, 0, 1]'::jsonb $$;

SELECT pg_temp.fill('sites', '{"display_name": "A", "raw_retention_s": 1000000000000}', until => 'retention_bound');
SELECT pg_temp.fill('sites', '{"display_name": "A"}', 'retention_bound');
SELECT pg_temp.fill('site_requests', '{"request_id": "r"}', 'site_requests');
SELECT pg_temp.fill('sites', '{"site_id": "going", "display_name": "G"}', 'site_deletion');
SELECT pg_temp.alter($$UPDATE enfilade.sites SET delete_time = now(), delete_actor = '' WHERE site_id = 'going'$$,
  'site_deletion');
SELECT pg_temp.fill('robots', '{"robot_id": "r", "display_name": "R"}');
SELECT pg_temp.fill('blobs', jsonb_build_object('sha256', pg_temp.hash(d), 'data', '\x00'))
  FROM unnest('{1,2}'::text[]) d;
SELECT pg_temp.fill('loose_blobs', jsonb_build_object('sha256', pg_temp.hash('1'), 'since', '-infinity',
  'entry', '00000000-0000-0000-0000-000000000001'));
SELECT pg_temp.fill('blob_listings', '{"listed_to": "\\x"}');
SELECT pg_temp.fill('image_features', jsonb_build_object('sha256', pg_temp.hash('1'), 'features', '\x00'));

SELECT pg_temp.fill('maps', jsonb_build_object('map_id', m, 'display_name', m, 'environment', 1, 'state', 3,
  'outline', 'POLYGON((0 0, 4 0, 4 4, 0 0))', 'current_revision', 1)) FROM unnest('{m1,m2}'::text[]) m;
SELECT pg_temp.fill('maps', '{"map_id": "old", "display_name": "Old", "environment": 1,
  "redirect_map_id": "m1", "redirect_x": 1, "redirect_y": 2, "redirect_yaw": 0}', 'rearrangements');

SELECT pg_temp.fill('sessions', '{"session_id": "mapped", "robot_id": "r", "map_id": "m1", "state": 3,
  "acknowledged_sequence": 2, "highest_sequence": 2, "laser_scans": 2, "finish_time": "2026-01-01", "initial_x": 1,
  "initial_y": 2, "initial_yaw": 0, "initial_covariance": [1, 0, 0, 0, 1, 0, 0, 0, 1]}');
SELECT pg_temp.fill('sessions', '{"session_id": "failed", "robot_id": "r", "state": 4, "error": "-"}');
SELECT pg_temp.fill('sessions', '{"session_id": "closed", "robot_id": "r", "state": 4, "error": "-",
  "acknowledged_sequence": 1, "highest_sequence": 3, "laser_scans": 2, "finish_time": "2026-01-01",
  "append_time": "2025-12-01"}', 'idle_sessions');
SELECT pg_temp.fill('sessions', '{"session_id": "deleted", "robot_id": "r", "state": 1}');
SELECT pg_temp.alter($$UPDATE enfilade.sessions SET robot_id = NULL, delete_time = now(), purged = true
  WHERE session_id = 'deleted'$$, 'sessions');
SELECT pg_temp.fill('sessions', '{"session_id": "doors", "robot_id": "r", "state": 1,
  "acknowledged_sequence": 2, "highest_sequence": 2, "laser_scans": 1, "door_reports": 1,
  "previous_session_id": "mapped"}', 'session_entries');
SELECT pg_temp.fill('sessions', '{"session_id": "rest", "robot_id": "r", "map_id": "m2", "state": 3,
  "acknowledged_sequence": 2, "highest_sequence": 2, "laser_scans": 1, "skipped_records": 1, "finish_time": "2026-01-01",
  "cut_from_session_id": "mapped", "recorded_sequence": 2}', 'rearrangements');
SELECT pg_temp.fill('session_records', jsonb_build_object('session_id', 'mapped', 'sequence', i, 'time_ns', i,
  'kind', 1, 'payload', '\x00')) FROM generate_series(1, 2) i;
SELECT pg_temp.fill('session_records', '{"session_id": "doors", "sequence": 1, "time_ns": 1, "kind": 1,
  "payload": "\\x00"}', 'session_entries');
SELECT pg_temp.fill('session_records', '{"session_id": "doors", "sequence": 2, "time_ns": 2, "kind": 6,
  "payload": "\\x00"}', 'session_entries');
SELECT pg_temp.fill('session_record_blobs', jsonb_build_object('session_id', 'mapped', 'sequence', 2,
  'sha256', pg_temp.hash('1')));

SELECT pg_temp.fill('map_revisions', jsonb_build_object('map_id', m, 'revision', 1, 'source', 2,
  'resolution', 0.05, 'origin_x', 0, 'origin_y', 0, 'origin_yaw', 0, 'width', 1, 'height', 1, 'raster_header', '\x00',
  'content_sha256', pg_temp.hash('3'), 'tile_count', 1, 'tile_bytes', 1)) FROM unnest('{m1,m2}'::text[]) m;
SELECT pg_temp.fill('map_revisions', jsonb_build_object('map_id', 'm1', 'revision', 2, 'source', 1,
  'session_id', 'mapped', 'resolution', 0.05, 'origin_x', 0, 'origin_y', 0, 'origin_yaw', 0, 'width', 1, 'height', 1,
  'raster_header', '\x00', 'content_sha256', pg_temp.hash('3'), 'tile_count', 1, 'tile_bytes', 1));
SELECT pg_temp.fill('revision_reviews', '{"map_id": "m1", "due_time": "infinity"}');
SELECT pg_temp.fill('map_revision_tiles', jsonb_build_object('map_id', 'm1', 'revision', 1, 'tile_row', 0,
  'tile_column', 0, 'sha256', pg_temp.hash('2')));
SELECT pg_temp.fill('raster_pyramids', '{"map_id": "m1", "revision": 1, "display_only": false, "lattice_column": 0,
  "lattice_row": 0, "thumbnail_zoom": 0, "thumbnail_column": 0, "thumbnail_row": 0, "thumbnail_width": 1,
  "thumbnail_cells": "\\x00"}');
SELECT pg_temp.fill('raster_pyramid_tiles', jsonb_build_object('map_id', 'm1', 'revision', 1, 'zoom', 0, 'tile_row', 0,
  'tile_column', 0, 'sha256', pg_temp.hash('2')));
SELECT pg_temp.fill('map_layers', '{"map_id": "m1", "position": 1, "revision": 1, "version": 1}');
SELECT pg_temp.fill('map_layers', '{"map_id": "m1", "position": 2, "session_id": "mapped",
  "raster_header": "\\x00", "version": 2}');
SELECT pg_temp.fill('map_layer_stacks', '{"map_id": "m1", "version": 2}');
SELECT pg_temp.fill('map_layer_runs', '{"map_id": "m1", "first_position": 1, "last_position": 2, "resolution": 0.05,
  "content_header": "\\x00"}');
SELECT pg_temp.fill('map_layer_run_tiles', jsonb_build_object('map_id', 'm1', 'first_position', 1, 'part', 2,
  'tile_row', 0, 'tile_column', 0, 'sha256', pg_temp.hash('2')));
SELECT pg_temp.fill('map_layer_tiles', jsonb_build_object('map_id', 'm1', 'position', 2, 'tile_row', 0,
  'tile_column', 0, 'sha256', pg_temp.hash('2')));

SELECT pg_temp.fill('session_leases', '{"session_id": "mapped", "owner": "o", "token": 1,
  "expires_at": "2026-01-01"}');
SELECT pg_temp.fill('mapping_work', '{"session_id": "mapped", "waiting_since": "2026-01-01",
  "turn_time": "2026-01-01"}');
SELECT pg_temp.fill('mapping_checkpoints', '{"session_id": "mapped", "mapped_sequence": 2, "token": 1,
  "paired": 2, "unpaired": 0, "time_reversed": 0, "used": 2, "keyframes": 1, "lost": 0, "state": "\\x00"}');
SELECT pg_temp.fill('slam_submaps', '{"session_id": "mapped", "submap_id": 0, "version": 1, "x": 0, "y": 0,
  "yaw": 0, "finished": true, "content": "\\x00"}');
SELECT pg_temp.fill('slam_nodes', jsonb_build_object('session_id', 'mapped', 'node_id', 0, 'sequence', 1,
  'time_ns', 1, 'x', 0, 'y', 0, 'yaw', 0, 'covariance', pg_temp.identity(), 'submap_id', 0));
SELECT pg_temp.fill('slam_closures', jsonb_build_object('session_id', 'mapped', 'closure_id', 0,
  'submap_id', 0, 'node_id', 0, 'x', 0, 'y', 0, 'yaw', 0, 'information', pg_temp.identity(), 'state', 1, 'score', 1,
  'chi2', 1, 'reason', '-'));
SELECT pg_temp.fill('trajectory_points', '{"session_id": "mapped", "sequence": 1, "time_ns": 1,
  "node_id": 0, "x": 0, "y": 0, "yaw": 0}');
SELECT pg_temp.fill('session_tracks', '{"session_id": "mapped", "map_id": "m1",
  "track": "LINESTRING M (0 0 1, 1 0 2)"}');

SELECT pg_temp.fill('link_points', jsonb_build_object('link_point_id', p, 'kind', 1, 'changed_version', 1))
  FROM unnest('{door,candidate}'::text[]) p;
SELECT pg_temp.fill('link_point_anchors', jsonb_build_object('link_point_id', p, 'map_id', m, 'ordinal', n,
  'x', n, 'y', 0, 'yaw', 0, 'covariance', pg_temp.identity()))
  FROM (VALUES ('door', 'm1', 1), ('door', 'm2', 2), ('candidate', 'm1', 1)) v (p, m, n);
SELECT pg_temp.fill('link_point_evidence', jsonb_build_object('link_point_id', 'door', 'map_id', 'm1',
  'kind', 1, 'encoding', 1, 'sha256', pg_temp.hash('1'), 'time_ns', 1));
SELECT pg_temp.fill('link_point_evidence', jsonb_build_object('link_point_id', 'door', 'map_id', 'm1',
  'kind', 1, 'encoding', 1, 'sha256', pg_temp.hash('1'), 'time_ns', 1, 'ordinal', 2), 'door_verdicts');
SELECT pg_temp.fill('graph_removals', '{"kind": 1, "id": "gone", "removed_version": 1}');
SELECT pg_temp.fill('graph_versions', '{"version": 1000, "cause": 7, "resource": "", "actor": ""}');
SELECT pg_temp.fill('graph_versions', '{"version": 1001, "cause": 9, "resource": "", "actor": ""}',
  'rearrangements');
SELECT pg_temp.fill('map_poses', jsonb_build_object('version', 1000, 'map_id', 'm1', 'x', 0, 'y', 0, 'yaw', 0,
  'covariance', pg_temp.identity()));
SELECT pg_temp.fill('control_points', '{"ordinal": 1, "map_id": "m1", "x": 0, "y": 0, "latitude": 48,
  "longitude": 11}');
SELECT pg_temp.fill('robot_poses', jsonb_build_object('robot_id', 'r', 'map_id', 'm1',
  'point', 'POINT M (0 0 1)', 'yaw', 0, 'covariance', pg_temp.identity(), 'time_ns', 1));
SELECT pg_temp.fill('audit_log', '{"audit_id": 1000000, "actor": "", "action": 1, "resource": "maps/m1",
  "after": {}}');

SELECT pg_temp.fill('solver_leases', '{"owner": "o", "token": 1, "expires_at": "2026-01-01"}');
SELECT pg_temp.fill('site_leases', '{"owner": "o", "token": 1, "expires_at": "2026-01-01"}');
SELECT pg_temp.fill('door_verdicts', '{"session_id": "doors", "sequence": 2, "decision": 1,
  "evidence": [1], "reason": "-", "graph_version": 1}');
SELECT pg_temp.fill('door_comparisons', '{"session_id": "doors", "sequence": 2, "ordinal": 1,
  "link_point_id": "door", "map_id": "m2", "images_agree": true, "inlier_share": 1, "clouds_agree": true,
  "accepted": true, "reason": "-"}');
SELECT pg_temp.fill('rearrangements', '{"rearrangement_id": "merge", "reason": "-", "version_before": 1,
  "version_after": 2}');
SELECT pg_temp.fill('rearrangement_parts', '{"rearrangement_id": "merge", "kind": 6, "subject": "old",
  "source": "old", "target": "m1", "x": 1, "y": 2, "yaw": 0, "ordinal": 1}');
SELECT pg_temp.fill('rearrangement_images', '{"rearrangement_id": "merge", "relation": "map", "key": "old",
  "before": {}}');
SELECT pg_temp.fill('rearrangement_blobs', jsonb_build_object('rearrangement_id', 'merge',
  'sha256', pg_temp.hash('2')));
SELECT pg_temp.fill('map_drafts', '{"map_id": "m1", "draft_id": "d", "display_name": "", "author": "", "base_edit_version": 0,
  "resolution": 0.05, "origin_x": 0, "origin_y": 0, "origin_yaw": 0, "head": 1, "next_sequence": 2, "active_edits": 1,
  "create_time": "2026-01-01", "etag": 1, "publish_time": "2026-01-01", "edit_version": 1, "revision": 1, "message": "-"}');
SELECT pg_temp.fill('map_edits', '{"map_id": "m1", "draft_id": "d", "sequence": 1, "edit_id": "e", "author": "", "head": 1,
  "active": true, "instruction": 3, "invisible": false, "shape": "\\x00", "create_time": "2026-01-01"}');
SELECT pg_temp.fill('map_overlays', '{"map_id": "m1", "edit_version": 1, "first_version": 1, "resolution": 0.05, "origin_x": 0,
  "origin_y": 0, "origin_yaw": 0, "evidence_header": "\\x00"}');
SELECT pg_temp.fill('map_overlay_tiles', jsonb_build_object('map_id', 'm1', 'part', 2, 'tile_row', 0, 'tile_column', 0,
  'sha256', pg_temp.hash('1')));
SELECT pg_temp.fill('prior_maps', '{"prior_map_id": "plan", "display_name": "Plan", "level": 0, "state": 2, "reason": "-",
  "file_name": "plan.png", "warnings": [], "walls": 8, "corners": 8, "doors": 0, "rooms": 1, "shafts": 0,
  "affine": [1, 0, 0, 0, -1, 0], "model": 2, "explained": 1, "contradicted": 0, "rival_ratio": 2, "aligned_maps": ["m1"],
  "graph_version": 1, "pair_maps": ["m1"], "pair_points": [1, 2, 3, 4], "align_time": "2026-01-01"}');
SELECT pg_temp.fill('prior_map_files', jsonb_build_object('prior_map_id', 'plan', 'product', 1, 'name', 'plan.png',
  'size_bytes', 1, 'sha256', pg_temp.hash('2')));
SELECT pg_temp.fill('map_areas', '{"map_id": "m1", "area_id": "glass", "display_name": "Glass", "kind": 4,
  "outline": "POLYGON((0 0, 1 0, 1 1, 0 0))", "robot_types": [], "speed_limit": 0, "etag": 1}');
SELECT pg_temp.fill('rearrangement_images', '{"rearrangement_id": "merge", "relation": "area", "key": "old/door",
  "before": {}}', 'map_areas');
SELECT pg_temp.fill('map_aliases', '{"map_id": "m1", "alias_id": "stable", "revision": 2, "previous_revision": 1,
  "actor": "-"}');
