// SPDX-License-Identifier: Apache-2.0
#include "core/edit/overlay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/sha256.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/edit/covered_cells.h"
#include "tests/unit/core/edit/random_edits.h"

namespace enfilade::edit {
namespace {

using Cells = std::vector<std::string>;

TEST(EditOverlay, TilesAndPlacesCountFromTheOrigin) {
  EXPECT_EQ(TileOf(0, 0), (grid::TileIndex{0, 0}));
  EXPECT_EQ(TileOf(255, 256), (grid::TileIndex{1, 0}));
  EXPECT_EQ(TileOf(-1, -256), (grid::TileIndex{-1, -1}));
  EXPECT_EQ(TileOf(-257, 511), (grid::TileIndex{1, -2}));
  EXPECT_EQ(PlaceInTile(0, 0), 0U);
  EXPECT_EQ(PlaceInTile(257, 2), 2U * 256 + 1);
  EXPECT_EQ(PlaceInTile(-1, -1), 65'535U);
  EXPECT_EQ(PlaceInTile(-256, -255), 256U);
}

TEST(EditOverlay, LaterEditsLieOverEarlierOnes) {
  Overlay overlay = OverlayIn({"####", "----"}, -2, -1);
  overlay.Draw({Instruction::kUnknown, Line{Centres({{-1, -2}, {-1, 0}})}, false});
  overlay.Draw({Instruction::kClear, Line{Centres({{1, 0}, {1, -1}})}, false});
  EXPECT_EQ(PictureOf(overlay, {-3, -2, 6, 3}), (Cells{".#?#x.", ".-?-x.", "..?..."}));
  EXPECT_EQ(overlay.tiles().size(), 4U);  // around the origin
}

// Each cell has the last edit's value that covers it.
TEST(EditOverlay, IsTheLastEditThatCoversACell) {
  std::mt19937 random(2);
  const RandomShapes shapes{{0, 0}, 9'000, 5'000};
  for (int trial = 0; trial < 20; ++trial) {
    Overlay overlay;
    std::map<std::pair<int, int>, Instruction> expected;
    for (int i = 0; i < 12; ++i) {
      const MapEdit edit{RandomInstruction(random), shapes.RandomShape(random), false};
      overlay.Draw(edit);
      for (const auto& cell : CoveredCells(edit.shape)) expected[cell] = edit.instruction;
    }
    std::size_t drawn = 0;
    for (const auto& [index, cells] : overlay.tiles()) {
      drawn += cells.size() - static_cast<std::size_t>(std::count(cells.begin(), cells.end(), std::uint8_t{0}));
    }
    EXPECT_EQ(drawn, expected.size());
    for (const auto& [cell, value] : expected) ASSERT_EQ(overlay.At(cell.first, cell.second), value);
  }
}

TEST(EditOverlay, DrawsIntoChosenTilesAlone) {
  std::mt19937 random(12);
  const RandomShapes shapes{{0, 0}, 30'000, 60'000};
  for (int i = 0; i < 100; ++i) {
    const MapEdit edit{Instruction::kFree, shapes.RandomShape(random), false};
    Overlay whole;
    whole.Draw(edit);
    std::set<grid::TileIndex> touched;
    for (const auto& [index, cells] : whole.tiles()) touched.insert(index);
    EXPECT_EQ(TilesOf(edit.shape), touched);
    Overlay first;
    const std::set<grid::TileIndex> only{*touched.begin()};
    first.Draw(edit, &only);
    whole.Draw(edit, &only);
    ASSERT_EQ(first.tiles().size(), 1U);
    EXPECT_EQ(first.tiles().begin()->second, *whole.Find(*touched.begin()));
  }
}

TEST(EditOverlay, HasNoTileWithoutInstructions) {
  Overlay overlay;
  overlay.Set({1, 2}, TileCells(kCellsOfTile));
  EXPECT_TRUE(overlay.empty());
  overlay.Set({1, 2}, TileCells(kCellsOfTile, 2));
  EXPECT_EQ(overlay.At(600, 300), Instruction::kFree);
  EXPECT_EQ(overlay.At(767, 511), Instruction::kFree);
  EXPECT_EQ(overlay.At(768, 511), Instruction::kNone);
  overlay.Set({1, 2}, TileCells(kCellsOfTile));
  EXPECT_EQ(overlay, Overlay());
  overlay = OverlayIn({"#"});
  overlay.Remove({0, 0});
  EXPECT_EQ(overlay, Overlay());
}

TEST(EditOverlay, DraftsLieOverWhatIsPublished) {
  const Overlay published = OverlayIn({"....", "####", "----", "????"});
  const Overlay draft = OverlayIn({".-#x", ".-#x", ".-#x", ".-#x"});
  EXPECT_EQ(PictureOf(Combine(published, draft), {0, 0, 4, 4}), (Cells{".-#.", "#-#.", "--#.", "?-#."}));
  EXPECT_EQ(Combine(published, Overlay()), published);
  EXPECT_EQ(Combine(Overlay(), OverlayIn({"x"})), Overlay());
  EXPECT_EQ(Combine(OverlayIn({"#"}), OverlayIn({"x"})), Overlay());  // the tile is gone
  EXPECT_EQ(Combine(nullptr, nullptr), TileCells(kCellsOfTile));
  EXPECT_EQ(Combine(published.Find({0, 0}), nullptr), *published.Find({0, 0}));
}

TEST(EditOverlay, DigestsAreOfTheBytesAsTheyAre) {
  const std::string zeros(65'536, '\0');
  EXPECT_EQ(DigestOf(nullptr), Sha256(zeros));
  TileCells cells(kCellsOfTile);
  EXPECT_EQ(DigestOf(&cells), Sha256(zeros));
  cells[258] = 3;
  std::string bytes = zeros;
  bytes[258] = 3;
  EXPECT_EQ(DigestOf(&cells), Sha256(bytes));
}

TEST(EditOverlay, TilesSurvivePacking) {
  std::mt19937 random(1);
  TileCells cells(kCellsOfTile);
  for (std::uint8_t& cell : cells) cell = static_cast<std::uint8_t>(random() % 5);
  ASSERT_OK_AND_ASSIGN(const TileCells unpacked, UnpackTile(Pack(cells)));
  EXPECT_EQ(unpacked, cells);
  std::string damaged = Pack(cells);
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x10);
  EXPECT_CODE(UnpackTile(damaged), absl::StatusCode::kDataLoss);
  EXPECT_CODE(UnpackTile(Pack(cells).substr(0, 100)), absl::StatusCode::kDataLoss);
  EXPECT_CODE(UnpackTile(""), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::edit
