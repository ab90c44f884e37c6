// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/plan_field.h"

#include <algorithm>
#include <cmath>

#include "core/prior/alignment/plan_transform.h"
#include "core/prior/plan/directions.h"

namespace enfilade::prior {

std::vector<Eigen::Vector2d> PointsOn(const std::vector<WallFace>& faces, double spacing) {
  std::vector<Eigen::Vector2d> points;
  for (const WallFace& face : faces) {
    const int steps = std::max(1, static_cast<int>(std::ceil((face.to - face.from).norm() / spacing)));
    for (int i = 0; i <= steps; ++i) {
      points.emplace_back(face.from + static_cast<double>(i) / steps * (face.to - face.from));
    }
  }
  return points;
}

PlanField::PlanField(const PlanGraph& plan, double metres_per_unit) : plan_(plan), unit_(metres_per_unit) {
  const PlanTransform to_plan{metres_per_unit * Eigen::Vector2d(1, -1).asDiagonal().toDenseMatrix(),
                              Eigen::Vector2d::Zero()};
  faces_ = Transformed(FacesOf(plan), to_plan);
  const std::vector<double> directions = DominantDirections(plan);
  if (!directions.empty()) axis_ = -directions.front();  // the sheet's y points down
  min_ = max_ = faces_.front().from;
  for (const WallFace& face : faces_) {
    min_ = min_.cwiseMin(face.from).cwiseMin(face.to);
    max_ = max_.cwiseMax(face.from).cwiseMax(face.to);
  }
  slam::LikelihoodField field(kResolution, kReach);
  field.Add(PointsOn(faces_, kResolution));
  const slam::CellWindow& window = field.window();
  low_ = (kResolution * Eigen::Vector2d(window.min.column, window.min.row)).cast<float>();
  width_ = window.width;
  height_ = window.height;
  squared_distances_ = field.squared_distances();
}

PlanField::Nearest PlanField::NearestAt(const Eigen::Vector2f& point) const {
  const std::size_t cell = CellOf(point);
  if (cell >= squared_distances_.size()) return {static_cast<float>(kReach * kReach)};
  Nearest nearest{squared_distances_[cell]};
  const std::size_t column = cell % static_cast<std::size_t>(width_);
  const std::size_t row = cell / static_cast<std::size_t>(width_);
  if (column == 0 || row == 0 || column + 1 == static_cast<std::size_t>(width_) ||
      row + 1 == static_cast<std::size_t>(height_)) {
    return nearest;
  }
  // The gradient of the squared distance points away from the wall, or is zero where the distance is cut.
  const Eigen::Vector2f gradient(squared_distances_[cell + 1] - squared_distances_[cell - 1],
                                 squared_distances_[cell + static_cast<std::size_t>(width_)] -
                                     squared_distances_[cell - static_cast<std::size_t>(width_)]);
  const float norm = gradient.norm();
  if (norm > 1e-6F) nearest.normal = gradient / norm;
  return nearest;
}

}  // namespace enfilade::prior
