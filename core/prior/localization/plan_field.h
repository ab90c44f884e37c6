// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/prior/alignment/wall_faces.h"
#include "core/prior/plan/plan_graph.h"
#include "core/slam/matching/likelihood_field.h"

namespace enfilade::prior {

// How far any place of a plan is from what robots see of its walls: their faces (FacesOf). In the plan frame
// (plan_state.h). Immutable.
class PlanField {
 public:
  static constexpr double kReach = 1.5;       // plan metres: walls farther away are not told apart
  static constexpr double kResolution = 0.1;  // plan metres

  struct Nearest {
    float squared_distance = 0;    // plan metres^2, at most kReach^2
    Eigen::Vector2f normal{0, 0};  // unit, away from the wall; zero on it and beyond kReach
  };

  // `metres_per_unit`: of the sheet, as far as known. The plan has walls, and is smaller than kLargestField.
  PlanField(const PlanGraph& plan, double metres_per_unit);

  // Of the cell that the point is in.
  float SquaredDistanceAt(const Eigen::Vector2f& point) const {
    const std::size_t cell = CellOf(point);
    return cell < squared_distances_.size() ? squared_distances_[cell] : static_cast<float>(kReach * kReach);
  }
  Nearest NearestAt(const Eigen::Vector2f& point) const;

  Eigen::Vector2d ToPlan(const Eigen::Vector2d& sheet) const { return {unit_ * sheet.x(), -unit_ * sheet.y()}; }
  Eigen::Vector2d ToSheet(const Eigen::Vector2d& plan) const { return {plan.x() / unit_, -plan.y() / unit_}; }

  const PlanGraph& plan() const { return plan_; }  // on the sheet
  double axis() const { return axis_; }  // rad, the direction of most walls: drawings are stretched along it or across
  double metres_per_unit() const { return unit_; }
  const std::vector<WallFace>& faces() const { return faces_; }  // in the plan frame
  const Eigen::Vector2d& min() const { return min_; }            // of the walls
  const Eigen::Vector2d& max() const { return max_; }

 private:
  std::size_t CellOf(const Eigen::Vector2f& point) const {
    const float column = (point.x() - low_.x()) * per_metre_;
    const float row = (point.y() - low_.y()) * per_metre_;
    if (!(column >= 0 && row >= 0 && column < static_cast<float>(width_) && row < static_cast<float>(height_)))
      return squared_distances_.size();
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
  }

  PlanGraph plan_;
  double unit_;
  double axis_ = 0;
  std::vector<WallFace> faces_;
  Eigen::Vector2d min_;
  Eigen::Vector2d max_;
  Eigen::Vector2f low_;  // the corner of the first cell
  float per_metre_ = static_cast<float>(1 / kResolution);
  int width_ = 0;
  int height_ = 0;
  std::vector<float> squared_distances_;  // row by row
};

constexpr double kLargestField = 500;  // plan metres, each side

// Points along the faces, at most `spacing` apart, both ends among them.
std::vector<Eigen::Vector2d> PointsOn(const std::vector<WallFace>& faces, double spacing);

}  // namespace enfilade::prior
