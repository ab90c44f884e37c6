// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "storage/postgres/driver/result.h"
#include "storage/postgres/graph/link_point_rows.h"

namespace enfilade::storage::postgres {

// A pose that may be missing, as the parameters of its columns: NULLs if it is.
struct PoseColumns {
  explicit PoseColumns(const std::optional<PoseWithCovariance>& pose) {
    if (!pose) return;
    x = pose->pose.x;
    y = pose->pose.y;
    yaw = pose->pose.yaw;
    covariance = ToRow(pose->covariance);
  }
  explicit PoseColumns(const std::optional<Pose2>& pose) {
    if (!pose) return;
    x = pose->x;
    y = pose->y;
    yaw = pose->yaw;
  }
  std::optional<double> x, y, yaw;
  std::optional<std::vector<double>> covariance;
};

// From three columns.
inline Pose2 ReadPose(Row& row) {
  const double x = row.Double();
  const double y = row.Double();
  return {x, y, row.Double()};
}
inline std::optional<Pose2> ReadOptionalPose(Row& row) {
  const auto x = row.OptionalDouble();
  const auto y = row.OptionalDouble();
  const auto yaw = row.OptionalDouble();
  if (!x || !y || !yaw) return std::nullopt;
  return Pose2{*x, *y, *yaw};
}

// From four; the covariance is {} if it is NULL.
inline std::optional<PoseWithCovariance> ReadOptionalPoseWithCovariance(Row& row) {
  const std::optional<Pose2> pose = ReadOptionalPose(row);
  const Eigen::Matrix3d covariance = ReadCovariance(row);
  if (!pose) return std::nullopt;
  return PoseWithCovariance{*pose, covariance};
}

}  // namespace enfilade::storage::postgres
