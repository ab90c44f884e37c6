-- SPDX-License-Identifier: Apache-2.0
-- When a session got its last records, so that one that nobody finishes can be closed. One with holes is closed as
-- failed. Each statement is a transaction, and the script can be repeated.

ALTER TABLE enfilade.sessions ADD COLUMN IF NOT EXISTS append_time timestamptz NOT NULL DEFAULT now();
ALTER TABLE enfilade.sessions DROP CONSTRAINT IF EXISTS sessions_without_holes_check;
ALTER TABLE enfilade.sessions ADD CONSTRAINT sessions_without_holes_check
  CHECK (finish_time IS NULL OR acknowledged_sequence = highest_sequence OR state = 4) NOT VALID;
ALTER TABLE enfilade.sessions VALIDATE CONSTRAINT sessions_without_holes_check;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.sessions_open_idx;
CREATE INDEX CONCURRENTLY sessions_open_idx ON enfilade.sessions (site_id, session_id)
  WHERE finish_time IS NULL AND delete_time IS NULL;
INSERT INTO enfilade.schema_compatibility VALUES ('idle_sessions', 'mapping_work') ON CONFLICT DO NOTHING;
