-- SPDX-License-Identifier: Apache-2.0
SELECT 1 / (enfilade.time_ordered_id() > 0)::integer;
