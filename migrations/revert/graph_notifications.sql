-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'graph_notifications';
CREATE FUNCTION enfilade.notify_graph() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  PERFORM pg_notify('enfilade_graph', NEW.site_id || ' ' || NEW.graph_version);
  RETURN NULL;
END $$;
CREATE TRIGGER site_graphs_notify AFTER UPDATE OF graph_version ON enfilade.site_graphs
  FOR EACH ROW EXECUTE FUNCTION enfilade.notify_graph();

COMMIT;
