// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/layer_runs.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "core/grid/overlay.h"
#include "server/app/mapping/layer_overlay.h"
#include "server/app/mapping/raster_revision.h"

namespace enfilade::server {
namespace {

bool AreOfOneRun(const storage::MapLayer& a, const storage::MapLayer& b) {
  return a.is_run() && a.first == b.first && a.last == b.last;
}

}  // namespace

std::optional<LayerSpan> SelectRun(const std::vector<storage::MapLayer>& layers, std::int64_t version) {
  const auto is_settled = [&](const storage::MapLayer& layer) { return layer.version + kSettledChanges <= version; };
  const auto is_single = [&](const storage::MapLayer& layer) { return is_settled(layer) && !layer.is_run(); };
  if (std::count_if(layers.begin(), layers.end(), is_single) < kMinSettledLayers) return std::nullopt;
  for (auto begin = layers.begin(); begin != layers.end();) {
    begin = std::find_if(begin, layers.end(), is_settled);
    auto end = std::find_if_not(begin, layers.end(), is_settled);
    const auto next = end;
    if (end - begin > kMaxLayersAtATime) {
      end = begin + kMaxLayersAtATime;
      if (AreOfOneRun(*(end - 1), *end)) ++end;
    }
    if (end - begin >= 2 && std::any_of(begin, end, is_single)) {
      return LayerSpan{static_cast<std::size_t>(begin - layers.begin()),
                       static_cast<std::size_t>(end - layers.begin())};
    }
    begin = next;
  }
  return std::nullopt;
}

absl::StatusOr<bool> LayerRuns::MakeNext(const storage::CallContext& context, double resolution,
                                         storage::LayersBeside& beside) const {
  for (std::vector<storage::MapLayer>* layers : {&beside.below, &beside.above}) {
    if (const auto span = SelectRun(*layers, beside.version)) {
      return Make(context, resolution, beside.version, *span, *layers);
    }
  }
  return false;
}

absl::StatusOr<bool> LayerRuns::Make(const storage::CallContext& context, double resolution, std::int64_t version,
                                     LayerSpan span, std::vector<storage::MapLayer>& layers) const {
  grid::LayerRun overlaid;
  for (std::size_t i = span.begin; i < span.end; ++i) {
    ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid layer,
                              ReadLayer(context, blobs_, site_, layers[i].raster, resolution));
    ENFILADE_ASSIGN_OR_RETURN(overlaid, grid::Extend(overlaid, layer));
  }
  if (overlaid.content.cells.empty()) return false;  // the layers show nothing
  storage::NewLayerRun run;
  run.first = layers[span.begin].first;
  run.last = layers[span.end - 1].last;
  run.resolution = resolution;
  run.layers_version = version;
  ENFILADE_ASSIGN_OR_RETURN(run, Put(context, std::move(run), std::move(overlaid)));
  const absl::Status added = revisions_.AddRun(context, site_, map_, run);
  if (storage::AreLayersChanged(added)) return false;
  ENFILADE_RETURN_IF_ERROR(added);
  const auto begin = layers.begin() + static_cast<std::ptrdiff_t>(span.begin);
  auto place = layers.erase(begin, layers.begin() + static_cast<std::ptrdiff_t>(span.end));
  place = layers.insert(place, {std::nullopt, std::move(run.content), run.first, run.last});
  if (run.reset) layers.insert(place, {std::nullopt, *std::move(run.reset), run.first, run.last});
  return true;
}

absl::StatusOr<bool> LayerRuns::MergeOrphaned(const storage::CallContext& context) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::OrphanedLayers orphaned,
                            revisions_.ReadOrphanedLayers(context, site_, map_, kMinSettledLayers, kMaxLayersAtATime));
  storage::NewLayerRun run;
  run.layers_version = orphaned.version;
  grid::LayerRun overlaid;
  int layers = 0;
  for (const storage::MapLayer& layer : orphaned.layers) {
    ENFILADE_ASSIGN_OR_RETURN(const grid::MapRaster raster, ReadRaster(context, blobs_, site_, layer.raster));
    if (layers > 0 && raster.geometry.resolution != run.resolution) {
      if (layers >= kMinSettledLayers) break;
      overlaid = {};
      layers = 0;
    }
    if (layers++ == 0) {
      run.first = layer.first;
      run.resolution = raster.geometry.resolution;
    }
    run.last = layer.last;
    ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid grid, OnMapLattice(raster, run.resolution));
    ENFILADE_ASSIGN_OR_RETURN(overlaid, grid::Extend(overlaid, grid));
  }
  if (layers < kMinSettledLayers || overlaid.content.cells.empty()) return false;
  ENFILADE_ASSIGN_OR_RETURN(run, Put(context, std::move(run), std::move(overlaid)));
  const absl::Status merged = revisions_.MergeLayers(context, site_, map_, run);
  if (storage::AreLayersChanged(merged)) return false;
  ENFILADE_RETURN_IF_ERROR(merged);
  return true;
}

absl::StatusOr<storage::NewLayerRun> LayerRuns::Put(const storage::CallContext& context, storage::NewLayerRun run,
                                                    grid::LayerRun overlaid) const {
  if (!overlaid.reset.cells.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(run.reset, PutRaster(context, std::move(overlaid.reset)));
  }
  ENFILADE_ASSIGN_OR_RETURN(run.content, PutRaster(context, std::move(overlaid.content)));
  return run;
}

absl::StatusOr<storage::StoredRaster> LayerRuns::PutRaster(const storage::CallContext& context,
                                                           grid::OccupancyGrid grid) const {
  ENFILADE_ASSIGN_OR_RETURN(const RasterRevision raster, ToRevision(grid::FromOccupancyGrid(std::move(grid))));
  ENFILADE_RETURN_IF_ERROR(PutTiles(context, blobs_, site_, raster, {}));
  return storage::StoredRaster{raster.revision.raster_header, raster.revision.tiles};
}

}  // namespace enfilade::server
