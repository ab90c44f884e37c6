-- SPDX-License-Identifier: Apache-2.0
-- Failed sessions with holes can then get records again.
BEGIN;

DELETE FROM enfilade.schema_compatibility WHERE change = 'idle_sessions';
DROP INDEX enfilade.sessions_open_idx;
UPDATE enfilade.sessions SET finish_time = NULL WHERE state = 4 AND acknowledged_sequence < highest_sequence;
ALTER TABLE enfilade.sessions DROP CONSTRAINT sessions_without_holes_check, ADD CONSTRAINT sessions_without_holes_check
  CHECK (finish_time IS NULL OR acknowledged_sequence = highest_sequence);
ALTER TABLE enfilade.sessions DROP COLUMN append_time;

COMMIT;
