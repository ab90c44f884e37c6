// SPDX-License-Identifier: Apache-2.0
#include "core/edit/history.h"

#include <algorithm>
#include <set>

#include "core/edit/patches.h"
#include "core/edit/spans.h"

namespace enfilade::edit {
namespace {

using grid::kTileSize;
using grid::TileIndex;

MapEdit OnLatticeOf(const KeptEdit& kept, const Lattice& lattice) {
  return {kept.edit.instruction, OnLattice(kept.edit.shape, kept.lattice, lattice), kept.edit.invisible};
}

// Whether the shape has a cell for which `holds` is true.
template <typename Holds>
bool HasCell(const Shape& shape, Holds holds) {
  bool found = false;
  VisitSpans(shape, [&](const Span& span) {
    for (int column = span.begin; column < span.end && !found; ++column) found = holds(column, span.row);
  });
  return found;
}

// Who of the edits' authors has drawn in a region of the marks.
class AuthorsOf {
 public:
  AuthorsOf(const Overlay& marks, const Region& region) : marks_(marks), region_(region) {}

  void Look(const std::vector<KeptEdit>& edits, const Lattice& lattice) {
    for (const KeptEdit& kept : edits) {
      if (!kept.active || authors_.contains(kept.author)) continue;
      const Shape shape = OnLattice(kept.edit.shape, kept.lattice, lattice);
      const bool drew = HasCell(shape, [&](int column, int row) {
        return region_.box.contains(column, row) && marks_.At(column, row) != Instruction::kNone;
      });
      if (drew) authors_.insert(kept.author);
    }
  }
  std::vector<std::string> Take() const { return {authors_.begin(), authors_.end()}; }

 private:
  const Overlay& marks_;
  const Region& region_;
  std::set<std::string> authors_;
};

// Marks a cell of an overlay that is made cell by cell.
class Marker {
 public:
  void Mark(TileIndex index, std::size_t place, Instruction value) {
    TileCells& cells = tiles_[index];
    cells.resize(kCellsOfTile);
    cells[place] = static_cast<std::uint8_t>(value);
  }
  Overlay Take() && {
    Overlay overlay;
    for (auto& [index, cells] : tiles_) overlay.Set(index, std::move(cells));
    return overlay;
  }

 private:
  std::map<TileIndex, TileCells> tiles_;
};

// Of each cell: the number of the publication that has edited it last, from 1; 0: none.
class LastPublications {
 public:
  void Draw(const Publication& publication, std::uint32_t number, const Lattice& lattice) {
    for (const KeptEdit& kept : publication.edits) {
      if (!kept.active) continue;
      const MapEdit edit = OnLatticeOf(kept, lattice);
      VisitSpans(edit.shape, [&](const Span& span) {
        for (int column = span.begin; column < span.end; ++column) {
          Cells& cells = tiles_[TileOf(column, span.row)];
          cells.resize(kCellsOfTile);
          cells[PlaceInTile(column, span.row)] = {number, edit.instruction, edit.invisible};
        }
      });
    }
  }

  struct Cell {
    std::uint32_t publication = 0;
    Instruction instruction = Instruction::kNone;
    bool invisible = false;
  };
  using Cells = std::vector<Cell>;
  const std::map<TileIndex, Cells>& tiles() const { return tiles_; }

 private:
  std::map<TileIndex, Cells> tiles_;
};

// The cells that say `instruction`.
Overlay Only(Instruction instruction, const Overlay& marks) {
  Overlay only;
  for (const auto& [index, cells] : marks.tiles()) {
    TileCells kept = cells;
    for (std::uint8_t& cell : kept) {
      if (cell != static_cast<std::uint8_t>(instruction)) cell = 0;
    }
    only.Set(index, std::move(kept));
  }
  return only;
}

bool Contests(const LastPublications::Cell& cell, grid::CellClass seen) {
  if (cell.instruction == Instruction::kFree) return seen == grid::CellClass::kOccupied;
  return cell.instruction == Instruction::kOccupied && !cell.invisible && seen == grid::CellClass::kFree;
}

std::size_t PlaceIn(const CellBox& box, int column, int row) {
  return static_cast<std::size_t>(row - box.first_row) * static_cast<std::size_t>(box.width) +
         static_cast<std::size_t>(column - box.first_column);
}

// The cells of each publication that the witness contests, by its number.
std::map<std::uint32_t, Overlay> ContestedCells(const LastPublications& last,
                                                const std::vector<Publication>& publications, const Witness& witness) {
  std::map<std::uint32_t, Marker> marks;
  for (const auto& [index, cells] : last.tiles()) {
    for (std::size_t place = 0; place < cells.size(); ++place) {
      const LastPublications::Cell& cell = cells[place];
      if (cell.publication == 0 || publications[cell.publication - 1].edit_version > witness.edit_version) continue;
      const int column = index.column * kTileSize + static_cast<int>(place % kTileSize);
      const int row = index.row * kTileSize + static_cast<int>(place / kTileSize);
      if (!witness.box.contains(column, row)) continue;
      if (!Contests(cell, witness.classes[PlaceIn(witness.box, column, row)])) continue;
      marks[cell.publication].Mark(index, place, cell.instruction);
    }
  }
  std::map<std::uint32_t, Overlay> contested;
  for (auto& [number, marker] : marks) contested.emplace(number, std::move(marker).Take());
  return contested;
}

}  // namespace

void DrawAll(const std::vector<KeptEdit>& edits, const Lattice& lattice, Overlay& overlay) {
  for (const KeptEdit& kept : edits) {
    if (kept.active) overlay.Draw(OnLatticeOf(kept, lattice));
  }
}

Overlay LayerOf(const std::vector<KeptEdit>& edits, const Lattice& lattice) {
  Overlay layer;
  DrawAll(edits, lattice, layer);
  return layer;
}

Overlay OverlayOf(const std::vector<Publication>& publications, const Lattice& lattice) {
  Overlay overlay;
  for (const Publication& publication : publications) {
    overlay = Combine(overlay, LayerOf(publication.edits, lattice));
  }
  return overlay;
}

std::vector<Conflict> FindConflicts(const Overlay& base, const Overlay& newest, const std::vector<KeptEdit>& draft,
                                    const std::vector<Publication>& since, const Lattice& lattice) {
  const Overlay mine = LayerOf(draft, lattice);
  Marker marker;
  for (const auto& [index, cells] : mine.tiles()) {
    const TileCells before = Combine(base.Find(index), nullptr);
    const TileCells theirs = Combine(newest.Find(index), nullptr);
    const TileCells ours = Combine(newest.Find(index), &cells);
    for (std::size_t place = 0; place < cells.size(); ++place) {
      if (cells[place] == 0 || theirs[place] == before[place] || theirs[place] == ours[place]) continue;
      marker.Mark(index, place, Instruction::kOccupied);
    }
  }
  const Overlay marks = std::move(marker).Take();
  std::vector<Conflict> conflicts;
  for (const Region& region : RegionsOf(marks)) {
    AuthorsOf mine_authors(marks, region);
    mine_authors.Look(draft, lattice);
    AuthorsOf their_authors(marks, region);
    for (const Publication& publication : since) their_authors.Look(publication.edits, lattice);
    conflicts.push_back({region, mine_authors.Take(), their_authors.Take()});
  }
  return conflicts;
}

std::vector<Contest> FindContests(const std::vector<Publication>& publications, const Lattice& lattice,
                                  const Witness& witness) {
  LastPublications last;
  for (std::size_t i = 0; i < publications.size(); ++i) {
    last.Draw(publications[i], static_cast<std::uint32_t>(i + 1), lattice);
  }
  std::vector<Contest> contests;
  for (const auto& [number, marks] : ContestedCells(last, publications, witness)) {
    const Publication& publication = publications[number - 1];
    for (const Region& region : RegionsOf(marks)) {
      if (region.cells < kMinContestedCells) continue;
      AuthorsOf authors(marks, region);
      authors.Look(publication.edits, lattice);
      const Instruction edited = marks.At(region.column, region.row);
      contests.push_back({region, edited, publication.edit_version, authors.Take(), publication.message,
                          PatchOf(Only(edited, marks), region.box)});
    }
  }
  return contests;
}

}  // namespace enfilade::edit
