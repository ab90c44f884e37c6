// SPDX-License-Identifier: Apache-2.0
#include "server/app/edits/map_edits.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/edit/apply.h"
#include "core/edit/integers.h"
#include "core/edit/spans.h"

namespace enfilade::server {
namespace {

using edit::Instruction;
using grid::CellClass;
using grid::TileIndex;

constexpr int kMaxToldEdits = 1000;

std::string NameOfDraft(const storage::MapDraftKey& key) { return NameOf(key.site, key.map, key.draft); }

CellClass ClassOf(Instruction instruction, CellClass below) {
  if (instruction == Instruction::kUnknown) return CellClass::kUnknown;
  if (instruction == Instruction::kFree) return CellClass::kFree;
  return instruction == Instruction::kOccupied ? CellClass::kOccupied : below;
}

bool IsOutside(const edit::Shape& shape, const edit::CellBox& map) {
  const edit::CellBox box = edit::BoxOf(shape);
  if (map.contains(box.first_column, box.first_row) && map.contains(box.end_column() - 1, box.end_row() - 1)) {
    return false;
  }
  bool inside = false;
  edit::VisitSpans(shape, [&](const edit::Span& span) {
    inside = inside || (span.row >= map.first_row && span.row < map.end_row() && span.begin < map.end_column() &&
                        span.end > map.first_column);
  });
  return !inside;
}

// Makes the stored form of edits that are drawn one after the other: each sees those before it.
class EditResolver {
 public:
  // `is_looked_at`: whether an edit after the first one depends on what those before it show.
  EditResolver(const MapGround& ground, const DraftView& view, bool is_looked_at)
      : ground_(ground), view_(view), is_looked_at_(is_looked_at), class_at_([this](int column, int row) {
          const Instruction new_one = drawn_.At(column, row);
          const CellClass seen = ground_.At(column, row);
          if (new_one == Instruction::kClear) return seen;
          return ClassOf(new_one != Instruction::kNone ? new_one : view_.At(column, row), seen);
        }) {}

  absl::StatusOr<storage::NewMapEdit> Resolve(const DrawnEdit& drawn) {
    storage::NewMapEdit resolved{drawn.id, drawn.author, drawn.edit};
    if (drawn.fill) {
      ENFILADE_ASSIGN_OR_RETURN(resolved.edit.shape,
                                edit::FilledCells(drawn.fill->seed, drawn.fill->bounds, ground_.box, class_at_));
    } else {
      ENFILADE_RETURN_IF_ERROR(edit::Validate(drawn.edit.shape));
    }
    if (!drawn.only_where.empty()) {
      ENFILADE_ASSIGN_OR_RETURN(resolved.edit.shape,
                                edit::CellsWhere(resolved.edit.shape, drawn.only_where, ground_.box, class_at_));
    }
    if (IsOutside(resolved.edit.shape, ground_.box)) {
      return InvalidArgument("it lies outside of the map, which has {} x {} cells from ({}, {})", ground_.box.width,
                             ground_.box.height, ground_.box.first_column, ground_.box.first_row);
    }
    ENFILADE_RETURN_IF_ERROR(edit::CanSay(ground_.header, drawn.edit.instruction));
    if (is_looked_at_) drawn_.Draw(resolved.edit);
    return resolved;
  }

 private:
  const MapGround& ground_;
  const DraftView& view_;
  const bool is_looked_at_;
  edit::Overlay drawn_;  // by this call
  const edit::ClassAt class_at_;
};

absl::Status InEdit(const absl::Status& status, std::size_t number, const DrawnEdit& drawn) {
  return absl::Status(status.code(),
                      fmt::format("edits[{}] ({}): {}", number, drawn.id, std::string(status.message())));
}

}  // namespace

std::shared_ptr<MapEdits::SharedView> MapEdits::ViewOf(const storage::MapDraftKey& key) {
  const std::string name = NameOfDraft(key);
  const MutexLock lock(mutex_);
  const auto found = std::find_if(views_.begin(), views_.end(), [&](const auto& entry) { return entry.first == name; });
  if (found != views_.end()) {
    views_.splice(views_.begin(), views_, found);
  } else {
    views_.emplace_front(name, std::make_shared<SharedView>(rasters_, edits_, key));
    if (views_.size() > kMaxViews) views_.pop_back();
  }
  return views_.front().second;
}

absl::StatusOr<storage::MapDraft> MapEdits::Create(const storage::CallContext& context, storage::MapDraft draft) {
  const EditedMap map{draft.key.site, draft.key.map};
  const auto ground = grounds_.Get(context, map);
  if (absl::IsNotFound(ground.status())) {
    return FailedPrecondition("{} has no revision yet: map it or import one, then edit it", NameOf(map.site, map.map));
  }
  ENFILADE_RETURN_IF_ERROR(ground.status());
  ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state, edits_.ReadOverlay(context, map.site, map.map));
  draft.lattice = (*ground)->lattice;
  draft.base_edit_version = state.overlay ? state.overlay->edit_version : 0;
  return edits_.Create(context, draft);
}

absl::StatusOr<DraftChange> MapEdits::ChangeSince(const storage::CallContext& context, DraftView& view,
                                                  std::int64_t known_head) {
  view.TakeChangedTiles();
  const std::int64_t before = view.draft().head;
  ENFILADE_RETURN_IF_ERROR(view.Update(context));
  DraftChange change;
  change.head = view.draft().head;
  const std::int64_t after = known_head > 0 ? known_head : before;
  for (const storage::StoredMapEdit& stored : view.edits()) {
    if (stored.head > after) change.edits.push_back(stored);
  }
  std::sort(change.edits.begin(), change.edits.end(), [](const auto& a, const auto& b) {
    return std::pair(a.head, a.kept.sequence) < std::pair(b.head, b.kept.sequence);
  });
  if (change.edits.size() > kMaxToldEdits) {
    change.edits.resize(kMaxToldEdits);
    change.head = change.edits.back().head - 1;  // the next call tells those of this head, too
  }
  for (const TileIndex& index : view.TakeChangedTiles()) {
    const edit::TileCells cells = view.Combined(index);
    change.tiles.push_back({index, edit::DigestOf(&cells)});
  }
  return change;
}

absl::StatusOr<DraftChange> MapEdits::Append(const storage::CallContext& context, const storage::MapDraftKey& key,
                                             absl::Span<const DrawnEdit> edits, std::int64_t known_head) {
  const std::shared_ptr<SharedView> shared = ViewOf(key);
  const MutexLock lock(shared->mutex);
  DraftView& view = shared->view;
  ENFILADE_RETURN_IF_ERROR(view.Update(context));
  ENFILADE_ASSIGN_OR_RETURN(const auto ground, grounds_.Get(context, {key.site, key.map}, view.draft().lattice));
  const bool is_looked_at = std::any_of(edits.begin(), edits.end(),
                                        [](const DrawnEdit& edit) { return edit.fill || !edit.only_where.empty(); });
  EditResolver resolver(*ground, view, is_looked_at);
  std::vector<storage::NewMapEdit> resolved;
  for (std::size_t i = 0; i < edits.size(); ++i) {
    absl::StatusOr<storage::NewMapEdit> edit = resolver.Resolve(edits[i]);
    if (!edit.ok()) return InEdit(edit.status(), i, edits[i]);
    resolved.push_back(*std::move(edit));
  }
  ENFILADE_RETURN_IF_ERROR(edits_.Append(context, key, resolved).status());
  return ChangeSince(context, view, known_head);
}

absl::StatusOr<DraftChange> MapEdits::SetActive(const storage::CallContext& context, const storage::MapDraftKey& key,
                                                absl::Span<const std::string> ids, bool active,
                                                const std::optional<std::string>& author, std::int64_t known_head) {
  const std::shared_ptr<SharedView> shared = ViewOf(key);
  const MutexLock lock(shared->mutex);
  ENFILADE_RETURN_IF_ERROR(shared->view.Update(context));
  ENFILADE_RETURN_IF_ERROR(edits_.SetActive(context, key, ids, active, author).status());
  return ChangeSince(context, shared->view, known_head);
}

absl::StatusOr<DraftTiles> MapEdits::ReadTiles(const storage::CallContext& context, const storage::MapDraftKey& key,
                                               absl::Span<const TileIndex> tiles) {
  const std::shared_ptr<SharedView> shared = ViewOf(key);
  const MutexLock lock(shared->mutex);
  DraftView& view = shared->view;
  ENFILADE_RETURN_IF_ERROR(view.Update(context));
  ENFILADE_ASSIGN_OR_RETURN(const auto ground, grounds_.Get(context, {key.site, key.map}, view.draft().lattice));
  DraftTiles answer;
  answer.head = view.draft().head;
  answer.box = ground->box;
  for (const TileIndex& index : tiles) {
    const edit::TileCells combined = view.Combined(index);
    const edit::TileCells* const base = view.base().Find(index);
    DraftTile& tile = answer.tiles.emplace_back(DraftTile{index, std::string(edit::kCellsOfTile, '\0')});
    for (std::size_t place = 0; place < edit::kCellsOfTile; ++place) {
      const int column = index.column * grid::kTileSize + static_cast<int>(place % grid::kTileSize);
      const int row = index.row * grid::kTileSize + static_cast<int>(place / grid::kTileSize);
      const auto seen = static_cast<int>(ground->At(column, row));
      const int published = base != nullptr ? (*base)[place] : 0;
      tile.cells[place] = static_cast<char>(seen | combined[place] << 2 | published << 4);
    }
  }
  const edit::CellBox& box = ground->box;
  const TileIndex first = edit::TileOf(box.first_column, box.first_row);
  const TileIndex last = edit::TileOf(box.end_column() - 1, box.end_row() - 1);
  for (TileIndex index = first; tiles.empty() && index.row <= last.row; ++index.row) {
    for (index.column = first.column; index.column <= last.column; ++index.column) answer.known.push_back(index);
  }
  return answer;
}

absl::StatusOr<DraftCheck> MapEdits::Check(const storage::CallContext& context, const storage::MapDraftKey& key) {
  const std::shared_ptr<SharedView> shared = ViewOf(key);
  const MutexLock lock(shared->mutex);
  ENFILADE_RETURN_IF_ERROR(shared->view.Update(context));
  return CheckView(context, shared->view);
}

absl::StatusOr<DraftCheck> MapEdits::CheckView(const storage::CallContext& context, const DraftView& view) {
  const storage::MapDraft& draft = view.draft();
  const EditedMap map{draft.key.site, draft.key.map};
  ENFILADE_ASSIGN_OR_RETURN(const auto ground, grounds_.Get(context, map, draft.lattice));
  ENFILADE_ASSIGN_OR_RETURN(const storage::OverlayState state, edits_.ReadOverlay(context, map.site, map.map));
  DraftCheck check;
  check.head = draft.head;
  // All on the draft's lattice, whatever the map's is by now.
  const edit::Lattice& lattice = draft.lattice;
  edit::Overlay newest;
  const std::vector<edit::KeptEdit> kept = view.KeptEdits();
  if (state.overlay) {
    check.edit_version = state.overlay->edit_version;
    ENFILADE_ASSIGN_OR_RETURN(newest, OverlayOn(context, map, *state.overlay, lattice));
    if (draft.base_edit_version != check.edit_version) {
      ENFILADE_ASSIGN_OR_RETURN(const edit::Overlay base, DrawOverlay(context, rasters_.revisions, map, *state.overlay,
                                                                      draft.base_edit_version, lattice));
      ENFILADE_ASSIGN_OR_RETURN(
          const std::vector<edit::Publication> since,
          rasters_.revisions.ReadPublications(context, map.site, map.map, draft.base_edit_version, check.edit_version));
      check.conflicts = edit::FindConflicts(base, newest, kept, since, lattice);
    }
  }
  const edit::Overlay& layer = view.layer();
  const edit::Overlay after = edit::Combine(newest, layer);
  if (layer.empty()) check.problems.push_back({true, "the draft has no active edits: there is nothing to publish"});
  for (const Instruction instruction : {Instruction::kUnknown, Instruction::kFree, Instruction::kOccupied}) {
    const bool is_used = std::any_of(kept.begin(), kept.end(), [&](const edit::KeptEdit& edit) {
      return edit.active && edit.edit.instruction == instruction;
    });
    const absl::Status sayable = is_used ? edit::CanSay(ground->header, instruction) : absl::OkStatus();
    if (!sayable.ok()) check.problems.push_back({true, std::string(sayable.message())});
  }
  const DraftComparison comparison(*ground, newest, after);
  comparison.Count(check.changes, check.box);
  if (const std::int64_t outside = comparison.CellsOutside(layer); outside > 0) {
    check.problems.push_back({false, fmt::format("{} edited cells lie outside of the map: they are seen once robots"
                                                 " have mapped what is there",
                                                 outside)});
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<PlaceInMap> places, PlacesIn(context, map));
  comparison.CheckPlaces(places, check.problems);
  return check;
}

absl::StatusOr<std::vector<PlaceInMap>> MapEdits::PlacesIn(const storage::CallContext& context,
                                                           const EditedMap& map) const {
  std::vector<PlaceInMap> places;
  storage::LinkPointFilter filter;
  filter.map = map.map;
  constexpr int kPage = 1000;
  for (storage::PageRequest page{kPage, {}};;) {
    ENFILADE_ASSIGN_OR_RETURN(const auto points, link_points_.List(context, map.site, filter, page));
    for (const storage::StoredLinkPoint& stored : points) {
      for (const graph::Anchor& anchor : stored.point.anchors) {
        if (anchor.map != map.map) continue;
        places.push_back({NameOf(map.site, stored.point.id), anchor.T_map_place.translation()});
      }
    }
    if (points.size() < kPage) return places;
    page.after = points.back().point.id.value();
  }
}

}  // namespace enfilade::server
