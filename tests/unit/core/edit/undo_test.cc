// SPDX-License-Identifier: Apache-2.0
// Undoing and redoing edits in any order, tile by tile as the server does it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/edit/history.h"
#include "tests/unit/core/edit/random_edits.h"

namespace enfilade::edit {
namespace {

const Lattice kMapLattice{0.05, {}};

// A draft whose tiles are drawn again where an edit is switched on or off.
class DrawnDraft {
 public:
  void Append(MapEdit edit) {
    const std::set<grid::TileIndex> tiles = TilesOf(edit.shape);
    tiles_.push_back(tiles);
    edits_.push_back({std::to_string(edits_.size()), "ann", static_cast<std::int64_t>(edits_.size()), true, kMapLattice,
                      std::move(edit)});
    Redraw(tiles);
  }
  void SetActive(std::size_t edit, bool active) {
    edits_[edit].active = active;
    Redraw(tiles_[edit]);
  }

  const std::vector<KeptEdit>& edits() const { return edits_; }
  const Overlay& layer() const { return layer_; }
  std::map<grid::TileIndex, std::string> Digests() const {
    std::map<grid::TileIndex, std::string> digests;
    for (const auto& [index, cells] : layer_.tiles()) digests[index] = DigestOf(&cells);
    return digests;
  }

 private:
  void Redraw(const std::set<grid::TileIndex>& tiles) {
    for (const grid::TileIndex& index : tiles) layer_.Remove(index);
    for (std::size_t i = 0; i < edits_.size(); ++i) {
      const bool touches =
          std::any_of(tiles.begin(), tiles.end(), [&](grid::TileIndex index) { return tiles_[i].contains(index); });
      if (edits_[i].active && touches) layer_.Draw(edits_[i].edit, &tiles);
    }
  }

  std::vector<KeptEdit> edits_;
  std::vector<std::set<grid::TileIndex>> tiles_;  // of each edit
  Overlay layer_;
};

TEST(Undo, AThousandOperationsReturnToTheStart) {
  std::mt19937 random(1000);
  const RandomShapes shapes{{0, 0}, 80'000, 12'000};
  DrawnDraft draft;
  for (int i = 0; i < 20; ++i) draft.Append({RandomInstruction(random), shapes.RandomShape(random), false});
  const auto start = draft.Digests();
  EXPECT_GT(start.size(), 4U);
  std::vector<std::size_t> done;
  std::vector<std::size_t> undone;
  for (int i = 0; i < 1000; ++i) {
    if (undone.empty() || random() % 3 != 0) {
      if (!done.empty() && random() % 3 == 0) {
        undone.push_back(done.back());
        done.pop_back();
        draft.SetActive(undone.back(), false);
      } else {
        done.push_back(draft.edits().size());
        draft.Append({RandomInstruction(random), shapes.RandomShape(random), false});
      }
    } else {
      done.push_back(undone.back());
      undone.pop_back();
      draft.SetActive(done.back(), true);
    }
    if (i % 50 != 0) continue;
    ASSERT_TRUE(draft.layer() == LayerOf(draft.edits(), kMapLattice)) << i;
  }
  EXPECT_GT(done.size(), 200U);
  EXPECT_NE(draft.Digests(), start);
  std::shuffle(done.begin(), done.end(), random);  // others undo theirs in any order
  for (const std::size_t edit : done) draft.SetActive(edit, false);
  EXPECT_EQ(draft.Digests(), start);
  for (std::size_t edit = 0; edit < 20; ++edit) draft.SetActive(edit, false);
  EXPECT_TRUE(draft.layer().empty());
}

}  // namespace
}  // namespace enfilade::edit
