// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/prior/alignment/plan_transform.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// What a robot may see of a wall: one of its two faces, or the line that stands for it where no thickness is drawn.
struct WallFace {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  int wall = 0;  // index in the plan
  // Away from the wall, not normalised; zero for the line of a wall without thickness, which is seen from both sides.
  Eigen::Vector2d outward = Eigen::Vector2d::Zero();
};

// In the sheet frame.
std::vector<WallFace> FacesOf(const PlanGraph& plan);
std::vector<WallFace> Transformed(const std::vector<WallFace>& faces, const PlanTransform& T_map_sheet);

struct NearestFace {
  int face = 0;           // index
  double fraction = 0;    // of the way from `from` to `to`
  Eigen::Vector2d point;  // on the face
  double distance = 0;    // m
  Eigen::Vector2d along;  // unit
};

// Finds the nearest face to a point. Immutable.
class FaceIndex {
 public:
  // Faces farther than `reach` (m) are not found.
  FaceIndex(std::vector<WallFace> faces, double reach);

  // `along`: only faces within `max_angle` (rad) of this direction; zero: all. `open`: only faces that look this way;
  // zero: all.
  std::optional<NearestFace> Nearest(const Eigen::Vector2d& point, const Eigen::Vector2d& along, double max_angle,
                                     const Eigen::Vector2d& open = Eigen::Vector2d::Zero()) const;
  const std::vector<WallFace>& faces() const { return faces_; }

 private:
  // A face as Nearest needs it.
  struct Line {
    Eigen::Vector2d from;
    Eigen::Vector2d way;
    double squared_length;
    Eigen::Vector2d along;  // unit
    Eigen::Vector2d outward;
  };

  std::vector<WallFace> faces_;
  std::vector<Line> lines_;
  double reach_;
  double bucket_;  // m, the side of one
  Eigen::Vector2d min_ = Eigen::Vector2d::Zero();
  int columns_ = 0;
  int rows_ = 0;
  // The faces within reach of each bucket, one after the other.
  std::vector<int> first_;
  std::vector<int> members_;
};

}  // namespace enfilade::prior
