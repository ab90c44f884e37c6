// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/edit/history.h"
#include "core/edit/overlay.h"
#include "server/app/edits/edited_revision.h"
#include "storage/maps/map_edit_store.h"

namespace enfilade::server {

// What one draft's edits make, kept up to date with the store. Not thread-safe.
class DraftView {
 public:
  DraftView(const RasterStores& rasters, const storage::MapEditStore& edits, storage::MapDraftKey key)
      : rasters_(rasters), edits_(edits), key_(std::move(key)) {}

  // Reads what has changed since the last time. NOT_FOUND.
  absl::Status Update(const storage::CallContext& context);
  // The tiles that changed since the last call.
  std::set<grid::TileIndex> TakeChangedTiles();

  const storage::MapDraft& draft() const { return draft_; }
  // By sequence.
  const std::vector<storage::StoredMapEdit>& edits() const { return stored_; }
  std::vector<edit::KeptEdit> KeptEdits() const;
  // The published edits that it lies over, its own, and both.
  const edit::Overlay& base() const { return base_; }
  const edit::Overlay& layer() const { return layer_; }
  edit::TileCells Combined(grid::TileIndex index) const;
  edit::Instruction At(int column, int row) const;
  // Of the newest publication when it was updated.
  const storage::OverlayState& newest() const { return newest_; }

 private:
  // Everything that was read: of a draft that is deleted, when another one has its name.
  void Forget();
  absl::Status UpdateBase(const storage::CallContext& context);
  absl::Status UpdateEdits(const storage::CallContext& context);
  void Apply(storage::StoredMapEdit edit);
  void Redraw();

  const RasterStores rasters_;
  const storage::MapEditStore& edits_;
  const storage::MapDraftKey key_;
  storage::MapDraft draft_;
  storage::OverlayState newest_;
  bool has_base_ = false;
  edit::Overlay base_;
  edit::Overlay layer_;
  std::vector<storage::StoredMapEdit> stored_;
  std::map<std::string, std::size_t> place_of_;      // by edit id
  std::vector<std::set<grid::TileIndex>> tiles_of_;  // of each edit
  std::int64_t head_ = 0, sequence_ = 0;             // of the last edit that was read
  std::set<grid::TileIndex> stale_;                  // to be drawn again
  std::set<grid::TileIndex> changed_;
};

}  // namespace enfilade::server
