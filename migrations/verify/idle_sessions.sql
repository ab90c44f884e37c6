-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT append_time FROM enfilade.sessions WHERE false;
SELECT 1 / count(*) FROM pg_indexes WHERE schemaname = 'enfilade' AND indexname = 'sessions_open_idx';

ROLLBACK;
