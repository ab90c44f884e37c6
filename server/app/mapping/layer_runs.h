// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/grid/overlay.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// A layer is settled once the map's layers have changed this often since it did. Sessions that are being mapped change
// theirs in turn, so that their layers are not settled while there are at most as many.
constexpr int kSettledChanges = 8;
// Settled layers below (or above) a session's that are not in runs, before they are overlaid: a run is stored as a
// whole, so that it must not be made again for every layer.
constexpr int kMinSettledLayers = 8;
// Of one run when it is made, those of older runs included: bounds what is done at a time.
constexpr int kMaxLayersAtATime = 64;

// Neighbours among layers: from `begin` to the one before `end`.
struct LayerSpan {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// The next layers to become one run. None if that is not worth while yet. `version`: LayersBeside::version.
std::optional<LayerSpan> SelectRun(const std::vector<storage::MapLayer>& layers, std::int64_t version);

// Overlays layers of a map beforehand, so that a revision does not cost more the more sessions the map has had: settled
// ones as runs, beside which they stay, and those of deleted sessions for good. Revisions stay the same cell by cell.
class LayerRuns {
 public:
  LayerRuns(const storage::BlobStore& blobs, const storage::RevisionStore& revisions, SiteId site, MapId map)
      : blobs_(blobs), revisions_(revisions), site_(std::move(site)), map_(std::move(map)) {}

  // Makes one run, if there is one to be made, and puts it in the place of its layers. `beside` was read for cells of
  // `resolution` m. False if nothing was to be done, or the layers have changed since they were read.
  absl::StatusOr<bool> MakeNext(const storage::CallContext& context, double resolution,
                                storage::LayersBeside& beside) const;

  // Merges the lowest layers of deleted sessions into one or two, if there are kMinSettledLayers with cells of one size
  // next to one another: nothing changes them any more. False as MakeNext.
  absl::StatusOr<bool> MergeOrphaned(const storage::CallContext& context) const;

 private:
  absl::StatusOr<bool> Make(const storage::CallContext& context, double resolution, std::int64_t version,
                            LayerSpan span, std::vector<storage::MapLayer>& layers) const;
  // `run` with its rasters.
  absl::StatusOr<storage::NewLayerRun> Put(const storage::CallContext& context, storage::NewLayerRun run,
                                           grid::LayerRun overlaid) const;
  absl::StatusOr<storage::StoredRaster> PutRaster(const storage::CallContext& context, grid::OccupancyGrid grid) const;

  const storage::BlobStore& blobs_;
  const storage::RevisionStore& revisions_;
  const SiteId site_;
  const MapId map_;
};

}  // namespace enfilade::server
