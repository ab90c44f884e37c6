// SPDX-License-Identifier: Apache-2.0
#include "core/edit/overlay.h"

#include <algorithm>
#include <optional>

#include "absl/types/span.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/edit/integers.h"
#include "core/edit/spans.h"
#include "core/grid/tile_codec.h"

namespace enfilade::edit {
namespace {

using grid::kTileSize;
using grid::TileIndex;

constexpr auto kNothing = static_cast<std::uint8_t>(Instruction::kNone);

bool HasInstructions(const TileCells& cells) {
  return std::any_of(cells.begin(), cells.end(), [](std::uint8_t cell) { return cell != kNothing; });
}

}  // namespace

TileIndex TileOf(int column, int row) {
  return {static_cast<int>(FloorDiv(row, kTileSize)), static_cast<int>(FloorDiv(column, kTileSize))};
}

std::size_t PlaceInTile(int column, int row) {
  const TileIndex tile = TileOf(column, row);
  return static_cast<std::size_t>(row - tile.row * kTileSize) * kTileSize +
         static_cast<std::size_t>(column - tile.column * kTileSize);
}

Instruction Overlay::At(int column, int row) const {
  const TileCells* const cells = Find(TileOf(column, row));
  return cells == nullptr ? Instruction::kNone : static_cast<Instruction>((*cells)[PlaceInTile(column, row)]);
}

const TileCells* Overlay::Find(TileIndex index) const {
  const auto found = tiles_.find(index);
  return found == tiles_.end() ? nullptr : &found->second;
}

void Overlay::Draw(const MapEdit& edit, const std::set<TileIndex>* only) {
  const auto value = static_cast<std::uint8_t>(edit.instruction);
  std::optional<TileIndex> last;
  TileCells* cells = nullptr;  // of `last`; null: not to be drawn in
  VisitSpans(edit.shape, [&](const Span& span) {
    for (int begin = span.begin; begin < span.end;) {
      const TileIndex index = TileOf(begin, span.row);
      const int end = std::min(span.end, (index.column + 1) * kTileSize);
      if (last != index) {
        last = index;
        cells = nullptr;
        if (only == nullptr || only->contains(index)) {
          cells = &tiles_[index];
          cells->resize(kCellsOfTile, kNothing);
        }
      }
      if (cells != nullptr)
        std::fill_n(cells->begin() + static_cast<std::ptrdiff_t>(PlaceInTile(begin, span.row)), end - begin, value);
      begin = end;
    }
  });
}

void Overlay::Set(TileIndex index, TileCells cells) {
  if (HasInstructions(cells)) {
    tiles_.insert_or_assign(index, std::move(cells));
  } else {
    tiles_.erase(index);
  }
}

std::set<TileIndex> TilesOf(const Shape& shape, std::size_t most) {
  std::set<TileIndex> tiles;
  TileIndex first_before, last_before;  // of the span before: those below it are often in the same tiles
  VisitSpans(shape, [&](const Span& span) {
    const TileIndex first = TileOf(span.begin, span.row);
    const TileIndex last = TileOf(span.end - 1, span.row);
    if (!tiles.empty() && first == first_before && last == last_before) return;
    first_before = first;
    last_before = last;
    for (TileIndex index = first; index.column <= last.column && tiles.size() <= most; ++index.column) {
      tiles.insert(index);
    }
  });
  return tiles;
}

TileCells Combine(const TileCells* published, const TileCells* draft) {
  TileCells cells = published != nullptr ? *published : TileCells(kCellsOfTile, kNothing);
  if (draft == nullptr) return cells;
  // Without a branch in it, so that the compiler makes many cells at once.
  constexpr auto kCleared = static_cast<std::uint8_t>(Instruction::kClear);
  const std::uint8_t* const own = draft->data();
  std::uint8_t* const out = cells.data();
  for (std::size_t i = 0; i < kCellsOfTile; ++i) {
    const std::uint8_t said = own[i] == kCleared ? kNothing : own[i];
    out[i] = own[i] == kNothing ? out[i] : said;
  }
  return cells;
}

Overlay Combine(const Overlay& published, const Overlay& draft) {
  Overlay combined = published;
  for (const auto& [index, cells] : draft.tiles()) combined.Set(index, Combine(published.Find(index), &cells));
  return combined;
}

std::string DigestOf(const TileCells* cells) {
  static const TileCells empty(kCellsOfTile, kNothing);
  const TileCells& bytes = cells != nullptr ? *cells : empty;
  return Sha256({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string Pack(const TileCells& cells) { return grid::TilePacking().Pack(cells); }

absl::StatusOr<TileCells> UnpackTile(std::string_view bytes) {
  TileCells cells(kCellsOfTile);
  ENFILADE_RETURN_IF_ERROR(grid::TilePacking().Unpack(bytes, absl::MakeSpan(cells)));
  return cells;
}

}  // namespace enfilade::edit
