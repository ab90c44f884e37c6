// SPDX-License-Identifier: Apache-2.0
#include "server/app/edits/draft_view.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

constexpr int kEditsAtATime = 1000;

bool HaveCommon(const std::set<grid::TileIndex>& few, const std::set<grid::TileIndex>& others) {
  return std::any_of(few.begin(), few.end(), [&](const grid::TileIndex& tile) { return others.contains(tile); });
}

}  // namespace

absl::Status DraftView::Update(const storage::CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(storage::MapDraft draft, edits_.Get(context, key_));
  if (has_base_ && draft.create_time != draft_.create_time) Forget();
  // An import may have put an end to what it lies over.
  const bool is_moved =
      !has_base_ || draft.base_edit_version != draft_.base_edit_version || draft.first_version != draft_.first_version;
  draft_ = std::move(draft);
  if (is_moved) ENFILADE_RETURN_IF_ERROR(UpdateBase(context));
  return draft_.head == head_ ? absl::OkStatus() : UpdateEdits(context);
}

void DraftView::Forget() {
  for (const auto& [index, cells] : layer_.tiles()) changed_.insert(index);
  layer_ = edit::Overlay();
  stored_.clear();
  place_of_.clear();
  tiles_of_.clear();
  stale_.clear();
  head_ = sequence_ = 0;
  has_base_ = false;
}

absl::Status DraftView::UpdateBase(const storage::CallContext& context) {
  ENFILADE_ASSIGN_OR_RETURN(newest_, edits_.ReadOverlay(context, key_.site, key_.map));
  edit::Overlay base;
  const std::int64_t version = draft_.base_edit_version;
  if (newest_.overlay && version >= newest_.overlay->first_version) {
    const storage::StoredOverlay& overlay = *newest_.overlay;
    if (version == overlay.edit_version && draft_.lattice == overlay.lattice) {
      ENFILADE_ASSIGN_OR_RETURN(base, ReadOverlay(context, rasters_.blobs, key_.site, overlay));
    } else {
      ENFILADE_ASSIGN_OR_RETURN(
          base, DrawOverlay(context, rasters_.revisions, {key_.site, key_.map}, overlay, version, draft_.lattice));
    }
  }
  for (const auto& [index, cells] : base_.tiles()) changed_.insert(index);
  for (const auto& [index, cells] : base.tiles()) changed_.insert(index);
  base_ = std::move(base);
  has_base_ = true;
  return absl::OkStatus();
}

absl::Status DraftView::UpdateEdits(const storage::CallContext& context) {
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(std::vector<storage::StoredMapEdit> news,
                              edits_.ListEdits(context, draft_, head_, sequence_, kEditsAtATime));
    for (storage::StoredMapEdit& edit : news) {
      head_ = edit.head;
      sequence_ = edit.kept.sequence;
      Apply(std::move(edit));
    }
    if (news.size() < kEditsAtATime) break;
  }
  // All up to the head that the draft had are read, and perhaps some that came after it.
  draft_.head = std::max(draft_.head, head_);
  head_ = draft_.head;
  sequence_ = std::numeric_limits<std::int64_t>::max();
  Redraw();
  return absl::OkStatus();
}

void DraftView::Apply(storage::StoredMapEdit edit) {
  const auto known = place_of_.find(edit.kept.id);
  if (known != place_of_.end()) {
    storage::StoredMapEdit& stored = stored_[known->second];
    if (stored.kept.active != edit.kept.active) {
      stale_.insert(tiles_of_[known->second].begin(), tiles_of_[known->second].end());
    }
    stored = std::move(edit);
    return;
  }
  // Appended edits come in the order of their sequences, but for those that were switched since: these have later
  // heads.
  const auto later = [](const storage::StoredMapEdit& a, std::int64_t sequence) { return a.kept.sequence < sequence; };
  const auto at = std::lower_bound(stored_.begin(), stored_.end(), edit.kept.sequence, later);
  const auto place = static_cast<std::size_t>(at - stored_.begin());
  std::set<grid::TileIndex> tiles = edit::TilesOf(edit.kept.edit.shape);
  if (place == stored_.size() && edit.kept.active && !HaveCommon(tiles, stale_)) {
    layer_.Draw(edit.kept.edit);
    changed_.insert(tiles.begin(), tiles.end());
  } else if (edit.kept.active) {
    stale_.insert(tiles.begin(), tiles.end());
  }
  if (place < stored_.size()) {
    for (auto& [id, known_place] : place_of_) known_place += known_place >= place ? 1 : 0;
  }
  place_of_.emplace(edit.kept.id, place);
  tiles_of_.insert(tiles_of_.begin() + static_cast<std::ptrdiff_t>(place), std::move(tiles));
  stored_.insert(stored_.begin() + static_cast<std::ptrdiff_t>(place), std::move(edit));
}

void DraftView::Redraw() {
  if (stale_.empty()) return;
  for (const grid::TileIndex& tile : stale_) layer_.Remove(tile);
  for (std::size_t i = 0; i < stored_.size(); ++i) {
    if (stored_[i].kept.active && HaveCommon(tiles_of_[i], stale_)) layer_.Draw(stored_[i].kept.edit, &stale_);
  }
  changed_.merge(stale_);
  stale_.clear();
}

std::set<grid::TileIndex> DraftView::TakeChangedTiles() { return std::exchange(changed_, {}); }

std::vector<edit::KeptEdit> DraftView::KeptEdits() const {
  std::vector<edit::KeptEdit> kept;
  for (const storage::StoredMapEdit& stored : stored_) kept.push_back(stored.kept);
  return kept;
}

edit::TileCells DraftView::Combined(grid::TileIndex index) const {
  return edit::Combine(base_.Find(index), layer_.Find(index));
}

edit::Instruction DraftView::At(int column, int row) const {
  const edit::Instruction own = layer_.At(column, row);
  if (own == edit::Instruction::kNone) return base_.At(column, row);
  return own == edit::Instruction::kClear ? edit::Instruction::kNone : own;
}

}  // namespace enfilade::server
