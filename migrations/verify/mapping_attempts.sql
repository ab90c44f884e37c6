-- SPDX-License-Identifier: Apache-2.0
BEGIN;

SELECT attempts FROM enfilade.session_leases WHERE false;

ROLLBACK;
