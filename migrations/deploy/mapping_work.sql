-- SPDX-License-Identifier: Apache-2.0
-- The sessions that wait to be mapped, so that looking for them does not look at all others. Each statement is a
-- transaction, and the script can be repeated: sessions are not locked while the queue is filled.

CREATE TABLE IF NOT EXISTS enfilade.mapping_work (
  site_id       text COLLATE "C" NOT NULL,
  session_id    enfilade.resource_id NOT NULL,
  waiting_since timestamptz NOT NULL DEFAULT now(),  -- its oldest record that is not mapped came then or later
  turn_time     timestamptz NOT NULL DEFAULT now(),  -- turns are taken in this order
  PRIMARY KEY (site_id, session_id),
  FOREIGN KEY (site_id, session_id) REFERENCES enfilade.sessions
) WITH (fillfactor = 50, autovacuum_vacuum_scale_factor = 0, autovacuum_vacuum_threshold = 1000);
CREATE INDEX IF NOT EXISTS mapping_work_turn_idx ON enfilade.mapping_work (turn_time);

INSERT INTO enfilade.schema_compatibility VALUES ('mapping_work', 'mapping_work') ON CONFLICT DO NOTHING;
INSERT INTO enfilade.mapping_work (site_id, session_id, turn_time)
  SELECT s.site_id, s.session_id, s.create_time FROM enfilade.sessions s
  LEFT JOIN enfilade.mapping_checkpoints c USING (site_id, session_id)
  WHERE s.map_id IS NOT NULL AND s.state IN (1, 2)
  AND (s.state = 2 OR s.acknowledged_sequence > coalesce(c.mapped_sequence, 0))
  ON CONFLICT DO NOTHING;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.sessions_to_map_idx;
