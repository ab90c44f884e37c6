// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/prior/alignment/fourier.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/alignment/wall_faces.h"

namespace enfilade::prior {

struct FoundTransform {
  PlanTransform T_map_sheet;
  double score = 0;
};

// Finds where on a sheet a map may lie, for a given turn and scale, by correlating images of both at all offsets at
// once (the convolution theorem).
class SheetSearch {
 public:
  // `cells`: of the images, along the sheet's longer side.
  SheetSearch(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, int cells);

  // The scales (m per unit) that are worth trying, the smallest first: the map is no larger than the sheet's walls, and
  // no smaller than a fraction of them.
  std::vector<double> Scales() const;

  // The best offsets. `linear`: of the transform. The score is the share of the map's walls that lie on walls of the
  // plan, less the length of the plan's walls in the map's free ground by the length of the map's walls.
  std::vector<FoundTransform> Find(const Eigen::Matrix2d& linear) const;

 private:
  struct GroundPoint {
    Eigen::Vector2d point;
    float area;  // m^2
  };

  Eigen::Vector2d ToCells(const Eigen::Vector2d& point_sheet) const { return (point_sheet - min_) / cell_; }

  const MapEvidence& evidence_;
  Eigen::Vector2d min_;  // of the sheet's walls, in its units
  Eigen::Vector2d size_;
  double cell_ = 1;  // units of the sheet
  double map_radius_ = 0;
  Eigen::Vector2d map_centre_;
  std::vector<WallPoint> points_;
  std::vector<GroundPoint> free_;
  // Transforms of the images of the plan: how near walls are, and their length (units) in each cell.
  ComplexImage nearness_;
  ComplexImage length_;
};

// So near to each other that the search misses no place between two of them, the smallest first.
std::vector<double> ScalesBetween(double least, double most);

}  // namespace enfilade::prior
