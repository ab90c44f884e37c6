-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT 1 / count(*) FROM pg_indexes WHERE schemaname = 'enfilade' AND indexname = 'map_poses_of_map_idx';
SELECT 1 / count(*) FROM pg_constraint WHERE conname = 'map_poses_whole';

ROLLBACK;
