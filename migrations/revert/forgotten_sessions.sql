-- SPDX-License-Identifier: Apache-2.0
DELETE FROM enfilade.schema_compatibility WHERE change = 'forgotten_sessions';
DROP INDEX CONCURRENTLY IF EXISTS enfilade.map_layers_of_session_idx;
DROP INDEX CONCURRENTLY IF EXISTS enfilade.sessions_to_forget_idx;
