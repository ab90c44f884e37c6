-- SPDX-License-Identifier: Apache-2.0
BEGIN;

ALTER TABLE enfilade.session_leases DROP COLUMN attempts;

COMMIT;
