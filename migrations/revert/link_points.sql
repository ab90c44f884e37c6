-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TRIGGER maps_join_graph ON enfilade.maps;
DROP TRIGGER maps_level ON enfilade.maps;
DROP TABLE enfilade.graph_removals;
DROP TABLE enfilade.link_point_evidence;
DROP TABLE enfilade.link_point_anchors;
DROP TABLE enfilade.link_points;
DROP TABLE enfilade.graph_maps;
DROP TABLE enfilade.site_graphs;
DROP FUNCTION enfilade.add_map_to_graph;
DROP FUNCTION enfilade.follow_level;
DROP FUNCTION enfilade.follow_anchors;
DROP FUNCTION enfilade.check_redundant_link_point;
DROP FUNCTION enfilade.refuse_redundant_link_point;
DROP FUNCTION enfilade.same_place_distance;
DROP FUNCTION enfilade.notify_graph;

COMMIT;
