-- SPDX-License-Identifier: Apache-2.0
-- Identifies sites by plain text: a sharded database finds no rows by a domain. The ids' form is checked in sites; every
-- other table's site is one of those. No table is rewritten and no index is built. Each statement is a transaction, so that
-- no two tables are locked for longer than needed, and the script can be repeated.

ALTER TABLE enfilade.sites
  DROP CONSTRAINT IF EXISTS sites_site_id_check,
  ADD CONSTRAINT sites_site_id_check CHECK (site_id ~ '^[a-z0-9]([a-z0-9-]{0,61}[a-z0-9])?$');
ALTER TABLE enfilade.sites ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.robots ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.blobs ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.maps ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.sessions ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.map_revisions ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.audit_log ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.control_points ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.door_comparisons ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.door_verdicts ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.graph_maps ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.graph_removals ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.graph_versions ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.image_features ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.link_point_anchors ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.link_point_evidence ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.link_points ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.map_layer_tiles ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.map_layers ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.map_poses ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.map_revision_tiles ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.mapping_checkpoints ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.rearrangement_blobs ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.rearrangement_images ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.rearrangement_parts ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.rearrangements ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.robot_poses ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.session_leases ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.session_record_blobs ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.session_tracks ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.site_graphs ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.site_leases ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.slam_closures ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.slam_nodes ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.slam_submaps ALTER site_id TYPE text COLLATE "C";
ALTER TABLE enfilade.trajectory_points ALTER site_id TYPE text COLLATE "C";
INSERT INTO enfilade.schema_compatibility VALUES ('site_id_text', 'schema_compatibility') ON CONFLICT DO NOTHING;
