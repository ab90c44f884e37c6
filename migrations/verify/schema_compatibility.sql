-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT 1 / count(*) FROM enfilade.schema_compatibility WHERE change = 'schema_compatibility';

ROLLBACK;
