-- SPDX-License-Identifier: Apache-2.0
SELECT prior_map_id, plan_withdrawn FROM enfilade.rearrangements WHERE false;
