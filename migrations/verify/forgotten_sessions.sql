-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT 1 / (count(*) - 1) FROM pg_indexes
  WHERE schemaname = 'enfilade' AND indexname IN ('sessions_to_forget_idx', 'map_layers_of_session_idx');

ROLLBACK;
