-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT waiting_since, turn_time FROM enfilade.mapping_work WHERE false;

ROLLBACK;
