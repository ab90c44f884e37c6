// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_rows.h"

#include "core/base/environment.h"
#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

// Of ENFILADE_LINK_POINT_COLUMNS.
constexpr int kIdColumn = 1;
constexpr int kFirstAnchorColumn = 21;

StoredLinkPoint ReadWithoutAnchors(Row& row) {
  StoredLinkPoint stored;
  graph::LinkPoint& point = stored.point;
  stored.site = SiteId(std::string(row.Text()));
  point.id = LinkPointId(std::string(row.Text()));
  point.kind = static_cast<graph::LinkPointKind>(row.Int16());
  point.tag = row.Text();
  point.direction = MapId(std::string(row.OptionalText().value_or("")));
  point.difficulty = row.Int32();
  const std::int16_t environment = row.Int16();
  if (environment != 0) stored.environment = static_cast<Environment>(environment);
  point.state = static_cast<graph::PassageState>(row.Int16());
  point.state_valid_until = row.OptionalTime();
  point.use = static_cast<graph::LinkPointUse>(row.Int16());
  stored.forced = row.Bool();
  point.pinned = row.Bool();
  const bool placed = row.Bool();
  PoseWithCovariance world;
  world.pose = {row.Double(), row.Double(), row.Double()};
  world.covariance = ReadCovariance(row);
  if (placed) stored.T_world_place = world;
  point.graph_version = row.Int64();
  stored.etag = row.Int64();
  stored.create_time = row.Time();
  stored.update_time = row.Time();
  return stored;
}

graph::Anchor ReadAnchor(Row& row) {
  graph::Anchor anchor;
  anchor.map = MapId(std::string(row.Text()));
  anchor.T_map_place = {row.Double(), row.Double(), row.Double()};
  anchor.covariance = ReadCovariance(row);
  return anchor;
}

}  // namespace

absl::StatusOr<std::vector<StoredLinkPoint>> ReadLinkPoints(const Result& result) {
  std::vector<StoredLinkPoint> link_points;
  for (int i = 0; i < result.rows(); ++i) {
    const std::string_view id = Row(result, i, kIdColumn).Text();
    if (link_points.empty() || link_points.back().point.id.value() != id) {
      Row row(result, i);
      link_points.push_back(ReadWithoutAnchors(row));
      ENFILADE_RETURN_IF_ERROR(row.status());
    }
    Row row(result, i, kFirstAnchorColumn);
    link_points.back().point.anchors.push_back(ReadAnchor(row));
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return link_points;
}

absl::StatusOr<StoredLinkPoint> ReadLinkPoint(const Result& result, const SiteId& site, const LinkPointId& id) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<StoredLinkPoint> link_points, ReadLinkPoints(result));
  if (link_points.empty()) return NotFound("{} does not exist", NameOf(site, id));
  return std::move(link_points.front());
}

std::vector<double> ToRow(const Eigen::Matrix3d& covariance) {
  std::vector<double> values;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) values.push_back(covariance(row, column));
  }
  return values;
}

AnchorArrays::AnchorArrays(const std::vector<graph::Anchor>& anchors) {
  for (const graph::Anchor& anchor : anchors) {
    maps.push_back(anchor.map.value());
    x.push_back(anchor.T_map_place.x);
    y.push_back(anchor.T_map_place.y);
    yaw.push_back(anchor.T_map_place.yaw);
    const std::vector<double> row = ToRow(anchor.covariance);
    covariances.insert(covariances.end(), row.begin(), row.end());
  }
}

Eigen::Matrix3d ReadCovariance(Row& row) {
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> covariance;
  if (!row.DoublesInto(absl::MakeSpan(covariance.data(), 9))) covariance.setZero();
  return covariance;
}

}  // namespace enfilade::storage::postgres
