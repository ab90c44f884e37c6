// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/graph/link_point_store.h"
#include "storage/postgres/driver/result.h"

namespace enfilade::storage::postgres {

// The columns that ReadLinkPoints reads: those of a link point (table p) and of one of its anchors (table a). The rows
// of a link point are adjacent.
#define ENFILADE_LINK_POINT_COLUMNS                                                                            \
  "p.site_id, p.link_point_id, p.kind, p.tag, p.direction_map_id, p.difficulty, p.environment, p.state,"       \
  " p.valid_until, p.\"use\", p.forced, p.pinned, p.position IS NOT NULL, coalesce(ST_X(p.position), 0),"      \
  " coalesce(ST_Y(p.position), 0), coalesce(p.yaw, 0), coalesce(p.world_covariance, '{}'), p.changed_version," \
  " p.etag, p.create_time, p.update_time, a.map_id, a.x, a.y, a.yaw, a.covariance"
#define ENFILADE_JOIN_ANCHORS \
  " JOIN enfilade.link_point_anchors a ON a.site_id = p.site_id AND a.link_point_id = p.link_point_id"

absl::StatusOr<std::vector<StoredLinkPoint>> ReadLinkPoints(const Result& result);
// The only one of `result`, or NOT_FOUND.
absl::StatusOr<StoredLinkPoint> ReadLinkPoint(const Result& result, const SiteId& site, const LinkPointId& id);

// 3x3, row by row.
std::vector<double> ToRow(const Eigen::Matrix3d& covariance);
// Anchors as arrays for unnest. `maps` refers to the anchors' ids.
struct AnchorArrays {
  explicit AnchorArrays(const std::vector<graph::Anchor>& anchors);

  std::vector<std::string_view> maps;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> yaw;
  std::vector<double> covariances;  // nine numbers for each anchor
};

// The next column, row by row; zeros unless it has nine numbers.
Eigen::Matrix3d ReadCovariance(Row& row);

}  // namespace enfilade::storage::postgres
