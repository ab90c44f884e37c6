// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/plan_graph.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <string_view>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::prior {
namespace {

bool IsConfidence(double value) { return value > 0 && value <= 1; }

absl::Status ValidateWall(const PlanGraph& plan, size_t index) {
  const PlanWall& wall = plan.walls[index];
  const auto has = [&](int corner) { return corner >= 0 && corner < static_cast<int>(plan.corners.size()); };
  if (!has(wall.from) || !has(wall.to)) {
    return InvalidArgument("wall {} joins corners {} and {}, of {}", index, wall.from, wall.to, plan.corners.size());
  }
  if (!(LengthOf(plan, wall) > 0)) return InvalidArgument("wall {} has no length", index);
  if (!std::isfinite(wall.thickness) || wall.thickness < 0) {
    return InvalidArgument("wall {} has a thickness of {}", index, wall.thickness);
  }
  if (!IsConfidence(wall.confidence)) {
    return InvalidArgument("wall {} has a confidence of {}", index, wall.confidence);
  }
  return absl::OkStatus();
}

absl::Status ValidateOutline(const std::vector<Eigen::Vector2d>& outline, std::string_view what, size_t index) {
  if (outline.size() < 3) {
    return InvalidArgument("{} {} has an outline of {} points", what, index, outline.size());
  }
  for (const Eigen::Vector2d& point : outline) {
    if (!point.allFinite()) return InvalidArgument("{} {} has a point that is not finite", what, index);
  }
  return absl::OkStatus();
}

}  // namespace

Eigen::Vector2d ToSheet(const PlanGraph& plan, const Eigen::Vector2d& picked) {
  return plan.H_sheet_photo ? (*plan.H_sheet_photo * picked.homogeneous()).eval().hnormalized() : picked;
}

double LengthOf(const PlanGraph& plan, const PlanWall& wall) {
  return (plan.corners[wall.to].point - plan.corners[wall.from].point).norm();
}

double WallLength(const PlanGraph& plan) {
  double length = 0;
  for (const PlanWall& wall : plan.walls) length += LengthOf(plan, wall);
  return length;
}

double DiagonalOf(const PlanGraph& plan) {
  if (plan.corners.empty()) return 0;
  Eigen::Vector2d low = plan.corners.front().point, high = low;
  for (const PlanCorner& corner : plan.corners) {
    low = low.cwiseMin(corner.point);
    high = high.cwiseMax(corner.point);
  }
  return (high - low).norm();
}

absl::Status Validate(const PlanGraph& plan) {
  for (size_t i = 0; i < plan.corners.size(); ++i) {
    if (!plan.corners[i].point.allFinite()) {
      return InvalidArgument("corner {} has a coordinate that is not finite", i);
    }
    if (plan.corners[i].point.cwiseAbs().maxCoeff() > kLargestCoordinate) {
      return InvalidArgument("corner {} has a coordinate beyond {:g}", i, kLargestCoordinate);
    }
  }
  for (size_t i = 0; i < plan.walls.size(); ++i) ENFILADE_RETURN_IF_ERROR(ValidateWall(plan, i));
  for (size_t i = 0; i < plan.doors.size(); ++i) {
    const PlanDoor& door = plan.doors[i];
    if (!door.from.allFinite() || !door.to.allFinite() || !IsConfidence(door.confidence)) {
      return InvalidArgument("door {} has a number that is not valid", i);
    }
  }
  for (size_t i = 0; i < plan.rooms.size(); ++i)
    ENFILADE_RETURN_IF_ERROR(ValidateOutline(plan.rooms[i].outline, "room", i));
  for (size_t i = 0; i < plan.shafts.size(); ++i)
    ENFILADE_RETURN_IF_ERROR(ValidateOutline(plan.shafts[i].outline, "shaft", i));
  if (plan.metres_per_unit && !(std::isfinite(*plan.metres_per_unit) && *plan.metres_per_unit > 0)) {
    return InvalidArgument("the plan has {} m a unit", *plan.metres_per_unit);
  }
  if (plan.H_sheet_photo && !(plan.H_sheet_photo->allFinite() && std::abs(plan.H_sheet_photo->determinant()) > 0)) {
    return InvalidArgument("the homography of the plan's photo has no inverse");
  }
  const double size = plan.metres_per_unit.value_or(0) * DiagonalOf(plan);
  if (size > kLargestPlan) {
    return InvalidArgument("by its scale the plan is {:.0f} m wide, at most {:.0f} m are possible", size, kLargestPlan);
  }
  return absl::OkStatus();
}

}  // namespace enfilade::prior
