-- SPDX-License-Identifier: Apache-2.0
-- The rows of sessions that were deleted long ago are deleted, too. Each statement is a transaction, and the script can be
-- repeated.

SET lock_timeout = 0;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.sessions_to_forget_idx;
CREATE INDEX CONCURRENTLY sessions_to_forget_idx ON enfilade.sessions (site_id, delete_time)
  WHERE purged AND delete_time IS NOT NULL;
-- For the foreign key: whether a layer refers to the session.
DROP INDEX CONCURRENTLY IF EXISTS enfilade.map_layers_of_session_idx;
CREATE INDEX CONCURRENTLY map_layers_of_session_idx ON enfilade.map_layers (site_id, session_id)
  WHERE session_id IS NOT NULL;
-- A deleted session refers to no other: those that were purged before this change, too. Nobody else writes these rows.
UPDATE enfilade.sessions SET previous_session_id = NULL, cut_from_session_id = NULL
  WHERE purged AND delete_time IS NOT NULL AND (previous_session_id IS NOT NULL OR cut_from_session_id IS NOT NULL);
INSERT INTO enfilade.schema_compatibility VALUES ('forgotten_sessions', 'robot_pose_order') ON CONFLICT DO NOTHING;
