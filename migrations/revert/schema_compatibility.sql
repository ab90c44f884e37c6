-- SPDX-License-Identifier: Apache-2.0
BEGIN;

DROP TABLE enfilade.schema_compatibility;

COMMIT;
