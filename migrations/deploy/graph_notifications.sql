-- SPDX-License-Identifier: Apache-2.0
-- Programs notify of new graph versions themselves: in a sharded database a trigger notifies on another node.
BEGIN;

DROP TRIGGER site_graphs_notify ON enfilade.site_graphs;
DROP FUNCTION enfilade.notify_graph;
INSERT INTO enfilade.schema_compatibility VALUES ('graph_notifications', 'graph_notifications');

COMMIT;
