-- SPDX-License-Identifier: Apache-2.0
SELECT display_name, level, state, reason, file_name, warnings, walls, corners, doors, rooms, shafts, metres_per_unit,
  affine, model, explained, contradicted, rival_ratio, aligned_maps, graph_version, pair_maps, pair_points, align_time,
  etag, create_time, update_time FROM enfilade.prior_maps WHERE false;
SELECT product, name, size_bytes, sha256 FROM enfilade.prior_map_files WHERE false;
