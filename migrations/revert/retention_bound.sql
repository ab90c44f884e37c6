-- SPDX-License-Identifier: Apache-2.0
BEGIN;

ALTER TABLE enfilade.sites DROP CONSTRAINT sites_raw_retention_max;

COMMIT;
