// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/edit/map_edit.h"
#include "core/edit/overlay.h"
#include "core/grid/raster_pyramid.h"

namespace enfilade::edit {

// An edit as it is kept.
struct KeptEdit {
  std::string id;
  std::string author;
  std::int64_t sequence = 0;  // in its draft
  bool active = true;
  Lattice lattice;
  MapEdit edit;
};

// The edits of a draft that was published, by sequence.
struct Publication {
  std::int64_t edit_version = 0;  // 1, 2, 3, ... of the map
  std::string message;
  std::vector<KeptEdit> edits;
};

// Draws the active edits, in their order, over what is there.
void DrawAll(const std::vector<KeptEdit>& edits, const Lattice& lattice, Overlay& overlay);

// What a draft's own edits say, kClear included.
Overlay LayerOf(const std::vector<KeptEdit>& edits, const Lattice& lattice);

// The overlay that publications make, in their order.
Overlay OverlayOf(const std::vector<Publication>& publications, const Lattice& lattice);

// Where a draft and what was published since it began say different things: neither may win by itself.
struct Conflict {
  Region region;
  std::vector<std::string> mine;    // authors, sorted
  std::vector<std::string> theirs;  // of `since` only
  Patch cells;                      // of the region; its box may have others, which are not in conflict
};
// `base` and `newest`: the overlay when the draft began and now; `since`: the publications between them.
std::vector<Conflict> FindConflicts(const Overlay& base, const Overlay& newest, const std::vector<KeptEdit>& draft,
                                    const std::vector<Publication>& since, const Lattice& lattice);

// What one session has seen, and how many publications there were when it began.
struct Witness {
  CellBox box;
  std::vector<grid::CellClass> classes;  // of the box's cells; sure ones only, others are unknown
  std::int64_t edit_version = 0;
};

// A place where a session that came after an edit has seen something else.
struct Contest {
  Region region;
  Instruction edited = Instruction::kNone;
  std::int64_t edit_version = 0;
  std::vector<std::string> authors;
  std::string message;
  Patch cells;  // of the region
};
// Fewer cells that touch one another are noise.
constexpr std::int64_t kMinContestedCells = 4;
// Free cells that it has seen occupied, and occupied ones that it has seen free, unless their edit says that scanners
// cannot see what is there. Cells that say "unknown" are never contested.
std::vector<Contest> FindContests(const std::vector<Publication>& publications, const Lattice& lattice,
                                  const Witness& witness);

}  // namespace enfilade::edit
