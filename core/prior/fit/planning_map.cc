// SPDX-License-Identifier: Apache-2.0
#include "core/prior/fit/planning_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/error.h"
#include "core/grid/map_raster.h"
#include "core/prior/plan/plan_cells.h"

namespace enfilade::prior {
namespace {

// Robots are less sure of what they have not seen.
constexpr double kPredictedWall = 0.9;
constexpr double kPredictedFree = 0.1;
constexpr double kMargin = 0.5;  // m around the plan

class PlanningMapMaker {
 public:
  PlanningMapMaker(const grid::OccupancyGrid& seen, const MapEvidence& evidence, const PlanGraph& plan,
                   const CorrectedPlan& corrected)
      : seen_(seen), evidence_(evidence), plan_(plan), corrected_(corrected) {}

  absl::StatusOr<PlanningMap> Run() {
    if (absl::Status status = Resize(); !status.ok()) return status;
    for (const PlanRoom& room : plan_.rooms) FillRoom(room);
    for (std::size_t i = 0; i < plan_.walls.size(); ++i) {
      if (corrected_.walls()[i].sight != Sight::kContradicted) DrawWall(plan_.walls[i]);
    }
    KeepSeen();
    return std::move(result_);
  }

 private:
  // In cells, from the lower left corner of the result.
  Eigen::Vector2d ToCells(const Eigen::Vector2d& point_map) const {
    return (Inverse(result_.map.geometry.T_map_grid) * point_map) / result_.map.geometry.resolution;
  }

  // Whole cells are added, so that those of `seen` stay where they are.
  absl::Status Resize() {
    result_.map.geometry = seen_.geometry;
    Eigen::Vector2d low(0, 0);
    Eigen::Vector2d high(seen_.geometry.width, seen_.geometry.height);
    const double margin = kMargin / seen_.geometry.resolution;
    for (const CorrectedCorner& corner : corrected_.corners()) {
      const Eigen::Vector2d cell = ToCells(corner.point);
      low = low.cwiseMin(cell - Eigen::Vector2d::Constant(margin));
      high = high.cwiseMax(cell + Eigen::Vector2d::Constant(margin));
    }
    low = low.array().floor();
    const Eigen::Vector2d size = high.array().ceil() - low.array();
    if (!(size.x() * size.y() <= static_cast<double>(grid::kMaxRasterCells))) {
      return InvalidArgument("the plan and the map are {:.0f} x {:.0f} cells large together", size.x(), size.y());
    }
    grid::GridGeometry& geometry = result_.map.geometry;
    const Eigen::Vector2d corner = geometry.T_map_grid * Eigen::Vector2d(low * geometry.resolution);
    geometry.T_map_grid.x = corner.x();
    geometry.T_map_grid.y = corner.y();
    geometry.width = static_cast<int>(size.x());
    geometry.height = static_cast<int>(size.y());
    column_of_seen_ = static_cast<int>(-low.x());
    row_of_seen_ = static_cast<int>(-low.y());
    result_.map.cells.assign(geometry.cell_count(), grid::kUnknownCell);
    result_.sources.assign(geometry.cell_count(), CellSource::kUnknown);
    return absl::OkStatus();
  }

  void Predict(std::size_t cell, double probability) {
    result_.map.cells[cell] = grid::CellFromProbability(probability);
    result_.sources[cell] = CellSource::kPredicted;
  }

  void FillRoom(const PlanRoom& room) {
    std::vector<Eigen::Vector2d> outline;
    for (const Eigen::Vector2d& corner : room.outline) outline.push_back(corrected_.Locate(corner).point);
    VisitInside(outline, result_.map.geometry, [this](std::size_t cell) { Predict(cell, kPredictedFree); });
  }

  void DrawWall(const PlanWall& wall) {
    VisitLine(corrected_.corners()[static_cast<std::size_t>(wall.from)].point,
              corrected_.corners()[static_cast<std::size_t>(wall.to)].point, wall.thickness * corrected_.scale(),
              result_.map.geometry, [this](std::size_t cell) { Predict(cell, kPredictedWall); });
  }

  // Where a picture has no unknown cells, what lies outside of its walls is not known either.
  void KeepSeen() {
    const bool has_unknown = std::find(seen_.cells.begin(), seen_.cells.end(), grid::kUnknownCell) != seen_.cells.end();
    for (int row = 0; row < seen_.geometry.height; ++row) {
      for (int column = 0; column < seen_.geometry.width; ++column) {
        const std::size_t from = seen_.geometry.index(column, row);
        if (seen_.cells[from] == grid::kUnknownCell) continue;
        if (!has_unknown && evidence_.ground[from] == Ground::kUnknown) continue;
        const std::size_t to = result_.map.geometry.index(column + column_of_seen_, row + row_of_seen_);
        result_.map.cells[to] = seen_.cells[from];
        result_.sources[to] = CellSource::kSeen;
      }
    }
  }

  const grid::OccupancyGrid& seen_;
  const MapEvidence& evidence_;
  const PlanGraph& plan_;
  const CorrectedPlan& corrected_;
  int column_of_seen_ = 0;
  int row_of_seen_ = 0;
  PlanningMap result_;
};

}  // namespace

absl::StatusOr<PlanningMap> MakePlanningMap(const grid::OccupancyGrid& seen, const MapEvidence& evidence,
                                            const PlanGraph& plan, const CorrectedPlan& corrected) {
  return PlanningMapMaker(seen, evidence, plan, corrected).Run();
}

PlanGraph CorrectedGraph(const PlanGraph& plan, const CorrectedPlan& corrected) {
  const auto to_sheet = [](const Eigen::Vector2d& point_map) -> Eigen::Vector2d {
    return {point_map.x(), -point_map.y()};
  };
  PlanGraph graph = plan;
  graph.metres_per_unit = 1.0;
  for (std::size_t i = 0; i < graph.corners.size(); ++i)
    graph.corners[i].point = to_sheet(corrected.corners()[i].point);
  const auto locate = [&](Eigen::Vector2d& point) { point = to_sheet(corrected.Locate(point).point); };
  for (PlanWall& wall : graph.walls) wall.thickness *= corrected.scale();
  for (PlanDoor& door : graph.doors) locate(door.from), locate(door.to);
  for (PlanRoom& room : graph.rooms) std::for_each(room.outline.begin(), room.outline.end(), locate);
  for (PlanShaft& shaft : graph.shafts) std::for_each(shaft.outline.begin(), shaft.outline.end(), locate);
  return graph;
}

}  // namespace enfilade::prior
