// SPDX-License-Identifier: Apache-2.0
#include "server/app/edits/map_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::server {
namespace {

// Coordinates that are whole but for rounding.
constexpr double kRounding = 1e-6;

int Floor(double cells) { return static_cast<int>(std::floor(cells)); }

// The cells of the lattice that the ground lies in.
edit::CellBox BoxOn(const MapGround& ground, const edit::Lattice& lattice) {
  const Pose2 T_lattice_ground = Inverse(lattice.T_map_lattice) * ground.lattice.T_map_lattice;
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (const int column : {ground.box.first_column, ground.box.end_column()}) {
    for (const int row : {ground.box.first_row, ground.box.end_row()}) {
      const Eigen::Array2d corner =
          (T_lattice_ground * Eigen::Vector2d(ground.lattice.resolution * column, ground.lattice.resolution * row))
              .array() /
          lattice.resolution;
      low = low.min(corner);
      high = high.max(corner);
    }
  }
  low += kRounding;
  high -= kRounding;
  edit::CellBox box{Floor(low.x()), Floor(low.y()), 0, 0};
  box.width = Floor(high.x()) + 1 - box.first_column;
  box.height = Floor(high.y()) + 1 - box.first_row;
  return box;
}

// Each cell shows what is at its centre.
MapGround Resampled(const MapGround& ground, const edit::Lattice& lattice, const edit::CellBox& box) {
  MapGround resampled{ground.revision, ground.create_time, ground.header, lattice, box, {}};
  resampled.classes.reserve(static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height));
  const Pose2 T_ground_lattice = Inverse(ground.lattice.T_map_lattice) * lattice.T_map_lattice;
  for (int row = box.first_row; row < box.end_row(); ++row) {
    for (int column = box.first_column; column < box.end_column(); ++column) {
      const Eigen::Vector2d at =
          T_ground_lattice * Eigen::Vector2d(lattice.resolution * (column + 0.5), lattice.resolution * (row + 0.5)) /
          ground.lattice.resolution;
      resampled.classes.push_back(ground.At(Floor(at.x()), Floor(at.y())));
    }
  }
  return resampled;
}

}  // namespace

grid::CellClass MapGround::At(int column, int row) const {
  if (!box.contains(column, row)) return grid::CellClass::kUnknown;
  return classes[static_cast<std::size_t>(row - box.first_row) * static_cast<std::size_t>(box.width) +
                 static_cast<std::size_t>(column - box.first_column)];
}

absl::StatusOr<std::shared_ptr<const MapGround>> MapGrounds::Get(const storage::CallContext& context,
                                                                 const EditedMap& map) {
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision newest, stores_.revisions.Get(context, map.site, map.map, 0));
  const auto is_same_map = [&](const Entry& entry) {
    return entry.site == map.site.value() && entry.map == map.map.value() && !entry.is_resampled;
  };
  {
    const MutexLock lock(mutex_);
    const auto found = std::find_if(entries_.begin(), entries_.end(), is_same_map);
    if (found != entries_.end() && found->ground->revision == newest.number &&
        found->ground->create_time == newest.create_time) {
      entries_.splice(entries_.begin(), entries_, found);
      return entries_.front().ground;
    }
  }
  ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster raster, ReadEvidence(context, stores_, newest));
  auto ground = std::make_shared<MapGround>();
  ground->revision = newest.number;
  ground->create_time = newest.create_time;
  ground->header = grid::HeaderOf(raster);
  ground->lattice = edit::LatticeOf(ground->header);
  ground->box = edit::BoxOf(ground->header);
  ground->classes = edit::ClassesOf(raster);
  const MutexLock lock(mutex_);
  entries_.remove_if(is_same_map);
  Keep({map.site.value(), map.map.value(), false, ground});
  return std::shared_ptr<const MapGround>(std::move(ground));
}

absl::StatusOr<std::shared_ptr<const MapGround>> MapGrounds::Get(const storage::CallContext& context,
                                                                 const EditedMap& map, const edit::Lattice& lattice) {
  ENFILADE_ASSIGN_OR_RETURN(std::shared_ptr<const MapGround> own, Get(context, map));
  if (own->lattice == lattice) return own;
  const auto is_same = [&](const Entry& entry) {
    return entry.site == map.site.value() && entry.map == map.map.value() && entry.is_resampled &&
           entry.ground->lattice == lattice;
  };
  {
    const MutexLock lock(mutex_);
    const auto found = std::find_if(entries_.begin(), entries_.end(), is_same);
    if (found != entries_.end() && found->ground->revision == own->revision &&
        found->ground->create_time == own->create_time) {
      entries_.splice(entries_.begin(), entries_, found);
      return entries_.front().ground;
    }
  }
  const edit::CellBox box = BoxOn(*own, lattice);
  if (static_cast<double>(box.width) * box.height > static_cast<double>(max_bytes_)) {
    return FailedPrecondition(
        "the cells of {} are {} m now, those of the draft {} m: publish or delete it, and make a"
        " new draft",
        NameOf(map.site, map.map), own->lattice.resolution, lattice.resolution);
  }
  auto ground = std::make_shared<const MapGround>(Resampled(*own, lattice, box));
  const MutexLock lock(mutex_);
  entries_.remove_if(is_same);
  Keep({map.site.value(), map.map.value(), true, ground});
  return ground;
}

void MapGrounds::Keep(Entry entry) {
  entries_.push_front(std::move(entry));
  std::size_t bytes = 0;
  for (auto kept = entries_.begin(); kept != entries_.end();) {
    bytes += kept->ground->classes.size();
    kept = bytes > max_bytes_ && kept != entries_.begin() ? entries_.erase(kept) : std::next(kept);
  }
}

}  // namespace enfilade::server
