// SPDX-License-Identifier: Apache-2.0
#include "server/app/edits/map_ground.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "core/grid/tiled_raster.h"

namespace enfilade::server {

grid::CellClass MapGround::At(int column, int row) const {
  if (!box.contains(column, row)) return grid::CellClass::kUnknown;
  return classes[static_cast<std::size_t>(row - box.first_row) * static_cast<std::size_t>(box.width) +
                 static_cast<std::size_t>(column - box.first_column)];
}

absl::StatusOr<std::shared_ptr<const MapGround>> MapGrounds::Get(const storage::CallContext& context,
                                                                 const EditedMap& map) {
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision newest, stores_.revisions.Get(context, map.site, map.map, 0));
  const auto is_same_map = [&](const Entry& entry) {
    return entry.site == map.site.value() && entry.map == map.map.value();
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
  ENFILADE_ASSIGN_OR_RETURN(ground->header, grid::DecodeRasterHeader(grid::SplitIntoTiles(raster).header));
  ground->lattice = edit::LatticeOf(ground->header);
  ground->box = edit::BoxOf(ground->header);
  ground->classes = edit::ClassesOf(raster);
  const MutexLock lock(mutex_);
  entries_.remove_if(is_same_map);
  entries_.push_front({map.site.value(), map.map.value(), ground});
  std::size_t bytes = 0;
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    bytes += entry->ground->classes.size();
    entry = bytes > max_bytes_ && entry != entries_.begin() ? entries_.erase(entry) : std::next(entry);
  }
  return std::shared_ptr<const MapGround>(std::move(ground));
}

}  // namespace enfilade::server
