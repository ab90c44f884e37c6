// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_rows.h"

#include <Eigen/Eigenvalues>
#include <set>

#include "core/base/environment.h"
#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

// Of ENFILADE_LINK_POINT_COLUMNS.
constexpr int kIdColumn = 1;
constexpr int kFirstAnchorColumn = 20;

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

Eigen::Matrix3d ReadCovariance(Row& row) {
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> covariance;
  if (!row.DoublesInto(absl::MakeSpan(covariance.data(), 9))) covariance.setZero();
  return covariance;
}

absl::Status ValidateCovariance(const std::string& field, const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return InvalidArgument("{} is not finite", field);
  const double scale = std::max(covariance.cwiseAbs().maxCoeff(), 1e-12);
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > 1e-9 * scale) {
    return InvalidArgument("{} is not symmetric", field);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  if (solver.eigenvalues()(0) < -1e-9 * scale) {
    return InvalidArgument("{} is not positive semi-definite: an eigenvalue is {}", field, solver.eigenvalues()(0));
  }
  return absl::OkStatus();
}

absl::Status ValidateAnchors(const std::vector<graph::Anchor>& anchors) {
  if (anchors.empty()) return InvalidArgument("anchors are missing: a link point has one at least");
  std::set<MapId> maps;
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    const graph::Anchor& anchor = anchors[i];
    if (!maps.insert(anchor.map).second) {
      return InvalidArgument("anchors[{}]: the map \"{}\" has an anchor already", i, anchor.map.value());
    }
    if (!IsFinite(anchor.T_map_place)) return InvalidArgument("anchors[{}].pose is not finite", i);
    ENFILADE_RETURN_IF_ERROR(ValidateCovariance(fmt::format("anchors[{}].covariance", i), anchor.covariance));
  }
  return absl::OkStatus();
}

}  // namespace enfilade::storage::postgres
