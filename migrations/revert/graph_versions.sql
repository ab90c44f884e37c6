-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TRIGGER site_graphs_record ON enfilade.site_graphs;
DROP TABLE enfilade.control_points;
DROP TABLE enfilade.map_poses;
DROP TABLE enfilade.graph_versions;
DROP FUNCTION enfilade.record_graph_version;

COMMIT;
