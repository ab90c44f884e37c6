// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "core/base/time.h"
#include "core/edit/apply.h"
#include "core/edit/map_edit.h"
#include "core/grid/raster_header.h"
#include "core/grid/raster_pyramid.h"
#include "server/app/edits/edited_revision.h"
#include "storage/maps/map_edit_store.h"

namespace enfilade::server {

// What a map shows below its edits.
struct MapGround {
  std::int64_t revision = 0;  // the newest one, that it is the evidence of
  TimeNs create_time = 0;     // of the revision: a map that is made again counts its revisions from 1 again
  grid::RasterHeader header;  // of the evidence
  edit::Lattice lattice;
  edit::CellBox box;
  std::vector<grid::CellClass> classes;  // of the box's cells, row by row from the lower left

  // Unknown outside of the box.
  grid::CellClass At(int column, int row) const;
};

// Of the maps that are edited: what was read last stays in memory, up to a limit. Thread-safe.
class MapGrounds {
 public:
  MapGrounds(const RasterStores& stores, std::size_t max_bytes) : stores_(stores), max_bytes_(max_bytes) {}

  // Of the newest revision, on its own lattice. NOT_FOUND if the map has none; errors as ReadEvidence.
  absl::StatusOr<std::shared_ptr<const MapGround>> Get(const storage::CallContext& context, const EditedMap& map);
  // The same on a lattice of before. FAILED_PRECONDITION if its cells are too small for the map of now.
  absl::StatusOr<std::shared_ptr<const MapGround>> Get(const storage::CallContext& context, const EditedMap& map,
                                                       const edit::Lattice& lattice);

 private:
  struct Entry {
    std::string site, map;
    bool is_resampled = false;
    std::shared_ptr<const MapGround> ground;
  };
  void Keep(Entry entry) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const RasterStores stores_;
  const std::size_t max_bytes_;
  Mutex mutex_;
  std::list<Entry> entries_ ABSL_GUARDED_BY(mutex_);  // most recently used first
};

}  // namespace enfilade::server
