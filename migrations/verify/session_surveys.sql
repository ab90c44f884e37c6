-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT surveyed FROM enfilade.sessions WHERE false;

ROLLBACK;
