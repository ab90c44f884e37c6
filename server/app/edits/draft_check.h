// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/edit/history.h"
#include "core/edit/map_edit.h"
#include "core/edit/overlay.h"
#include "server/app/edits/map_ground.h"

namespace enfilade::server {

// What speaks for and against publishing a draft.

struct ChangeCounts {
  std::int64_t to_unknown = 0;
  std::int64_t to_free = 0;
  std::int64_t to_occupied = 0;

  std::int64_t sum() const { return to_unknown + to_free + to_occupied; }
};

struct DraftProblem {
  bool is_error = false;  // else a warning
  std::string message;
  std::optional<edit::CellBox> box = std::nullopt;
};

struct DraftCheck {
  ChangeCounts changes;
  edit::CellBox box;  // around the changes; empty: none
  std::vector<DraftProblem> problems;
  std::vector<edit::Conflict> conflicts;
  std::int64_t edit_version = 0;  // of the newest publication, against which the conflicts are
  std::int64_t head = 0;
};

// A link point as the map has it.
struct PlaceInMap {
  std::string name;
  Eigen::Vector2d point_map = Eigen::Vector2d::Zero();  // m
};

// How the map would change, cell by cell, from `before` to `after`: both lie over the same ground, on its lattice.
class DraftComparison {
 public:
  DraftComparison(const MapGround& ground, const edit::Overlay& before, const edit::Overlay& after)
      : ground_(ground), before_(before), after_(after) {}

  void Count(ChangeCounts& changes, edit::CellBox& box) const;
  // Of the draft's own edits: cells that lie outside of the map.
  std::int64_t CellsOutside(const edit::Overlay& layer) const;
  // Link points in the way of new obstacles, or cut off from one another by them.
  void CheckPlaces(const std::vector<PlaceInMap>& places, std::vector<DraftProblem>& problems) const;

 private:
  grid::CellClass Class(edit::Instruction edited, int column, int row) const;
  std::vector<int> ReachableParts(const edit::Overlay& overlay, const std::vector<PlaceInMap>& places) const;
  edit::CellBox CellsAround(const PlaceInMap& place) const;

  const MapGround& ground_;
  const edit::Overlay& before_;
  const edit::Overlay& after_;
};

}  // namespace enfilade::server
