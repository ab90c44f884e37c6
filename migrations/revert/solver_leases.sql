-- SPDX-License-Identifier: Apache-2.0
BEGIN;
DELETE FROM enfilade.schema_compatibility WHERE change = 'solver_leases';
DROP TABLE enfilade.solver_leases;
COMMIT;
