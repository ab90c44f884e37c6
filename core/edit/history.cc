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

// Who of the edits' authors has drawn in each region.
class RegionAuthors {
 public:
  explicit RegionAuthors(const RegionMap& map) : map_(map), authors_(map.regions.size()) {}

  void Look(const std::vector<KeptEdit>& edits, const Lattice& lattice) {
    if (authors_.empty()) return;
    for (const KeptEdit& kept : edits) {
      if (!kept.active) continue;
      VisitSpans(OnLattice(kept.edit.shape, kept.lattice, lattice), [&](const Span& span) { Look(kept.author, span); });
    }
  }
  // Sorted. `region`: its place in the map's regions.
  std::vector<std::string> Of(std::size_t region) const { return {authors_[region].begin(), authors_[region].end()}; }

 private:
  void Look(const std::string& author, const Span& span) {
    for (int begin = span.begin; begin < span.end;) {
      const TileIndex index = TileOf(begin, span.row);
      const int end = std::min(span.end, (index.column + 1) * kTileSize);
      const auto numbers = map_.numbers.find(index);
      for (; numbers != map_.numbers.end() && begin < end; ++begin) {
        const std::uint32_t number = numbers->second[PlaceInTile(begin, span.row)];
        if (number != 0) authors_[number - 1].insert(author);
      }
      begin = end;
    }
  }

  const RegionMap& map_;
  std::vector<std::set<std::string>> authors_;
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
  const RegionMap map = MapRegions(marks);
  RegionAuthors my_authors(map);
  my_authors.Look(draft, lattice);
  RegionAuthors their_authors(map);
  for (const Publication& publication : since) their_authors.Look(publication.edits, lattice);
  std::vector<Conflict> conflicts;
  for (std::size_t i = 0; i < map.regions.size(); ++i) {
    conflicts.push_back({map.regions[i], my_authors.Of(i), their_authors.Of(i), CellsOf(map, i)});
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
    const RegionMap map = MapRegions(marks);
    RegionAuthors authors(map);
    authors.Look(publication.edits, lattice);
    for (std::size_t i = 0; i < map.regions.size(); ++i) {
      const Region& region = map.regions[i];
      if (region.cells < kMinContestedCells) continue;
      contests.push_back({region, marks.At(region.column, region.row), publication.edit_version, authors.Of(i),
                          publication.message, CellsOf(map, i)});
    }
  }
  return contests;
}

}  // namespace enfilade::edit
