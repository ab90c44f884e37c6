// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::perception {

struct NearPoint {
  int index = -1;                 // -1: no points
  float squared_distance = 0.0F;  // m^2
};

// Exact nearest neighbours among points, by PCL's kd-tree. Thread-safe once constructed.
class NearestPoints {
 public:
  // INVALID_ARGUMENT: no points, or one that is not finite.
  static absl::StatusOr<NearestPoints> Make(std::span<const Eigen::Vector3f> points);
  ~NearestPoints();
  NearestPoints(NearestPoints&&) noexcept;
  NearestPoints& operator=(NearestPoints&&) noexcept;

  NearPoint Nearest(const Eigen::Vector3f& point) const;
  // The `count` nearest points, or all if there are fewer, nearest first.
  std::vector<int> Neighbours(const Eigen::Vector3f& point, int count) const;

 private:
  struct Tree;
  explicit NearestPoints(std::unique_ptr<Tree> tree);
  std::unique_ptr<Tree> tree_;
};

}  // namespace enfilade::perception
