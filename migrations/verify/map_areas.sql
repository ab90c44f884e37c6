-- SPDX-License-Identifier: Apache-2.0
SELECT site_id, map_id, area_id, display_name, kind, outline, robot_types, speed_limit, valid_from, valid_until, request_id,
  request_sha256, etag, create_time, update_time FROM enfilade.map_areas WHERE false;
SELECT 'enfilade.rearrangement_image_but_areas(text, text, text)'::regprocedure,
  enfilade.rearrangement_image('', 'area', '');
