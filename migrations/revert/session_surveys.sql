-- SPDX-License-Identifier: Apache-2.0
BEGIN;

ALTER TABLE enfilade.sessions DROP COLUMN surveyed;

COMMIT;
