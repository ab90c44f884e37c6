-- SPDX-License-Identifier: Apache-2.0
SELECT 1 / (pg_get_expr(adbin, adrelid) LIKE '%time_ordered_id%')::integer FROM pg_attrdef d
  JOIN pg_attribute a ON a.attrelid = d.adrelid AND a.attnum = d.adnum
  WHERE d.adrelid = 'enfilade.robot_poses'::regclass AND a.attname = 'version';
