-- SPDX-License-Identifier: Apache-2.0
SELECT 1 / count(*) FROM information_schema.key_column_usage
  WHERE table_schema = 'enfilade' AND constraint_name = 'rearrangement_parts_pkey' AND column_name = 'ordinal';
