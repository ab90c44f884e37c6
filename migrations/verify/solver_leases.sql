-- SPDX-License-Identifier: Apache-2.0
SELECT site_id, owner, token, expires_at FROM enfilade.solver_leases WHERE false;
