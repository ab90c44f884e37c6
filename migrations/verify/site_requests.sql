-- SPDX-License-Identifier: Apache-2.0
SELECT request_id, site_id, create_time FROM enfilade.site_requests WHERE false;
