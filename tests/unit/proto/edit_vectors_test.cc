// SPDX-License-Identifier: Apache-2.0
// The golden vectors of edits, which the dashboard draws, too. They were made by a program that shares no code with
// core/edit.
#include "tests/support/edits/edit_vectors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/edit/overlay.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

std::map<grid::TileIndex, EditVectors::Tile> TilesIn(const edit::Overlay& overlay) {
  std::map<grid::TileIndex, EditVectors::Tile> tiles;
  for (const auto& [index, cells] : overlay.tiles()) {
    tiles[index] = {edit::DigestOf(&cells),
                    static_cast<std::int64_t>(cells.size()) - std::count(cells.begin(), cells.end(), std::uint8_t{0})};
  }
  return tiles;
}

class EditVectorFile : public ::testing::TestWithParam<std::filesystem::path> {};
INSTANTIATE_TEST_SUITE_P(Edits, EditVectorFile, ::testing::ValuesIn(EditVectorFiles()),
                         [](const auto& file) { return file.param.stem().string(); });

TEST_P(EditVectorFile, IsDrawnAsItSays) {
  ASSERT_OK_AND_ASSIGN(const EditVectors vectors, ReadEditVectors(GetParam()));
  ASSERT_FALSE(vectors.edits.empty());
  edit::Overlay drawn;
  for (const v1::MapEdit& edit : vectors.edits) drawn.Draw(ToCoreEdit(edit));
  EXPECT_TRUE(TilesIn(edit::Combine({}, drawn)) == vectors.tiles);
}

TEST_P(EditVectorFile, HasEditsThatAreValidAndSurviveStorage) {
  ASSERT_OK_AND_ASSIGN(const EditVectors vectors, ReadEditVectors(GetParam()));
  std::set<std::string> ids;
  for (const v1::MapEdit& edit : vectors.edits) {
    const edit::Shape shape = ToCoreEdit(edit).shape;
    EXPECT_OK(edit::Validate(shape)) << edit.edit_id();
    ASSERT_OK_AND_ASSIGN(const edit::Shape stored, edit::DecodeShape(edit::Encode(shape)));
    EXPECT_EQ(stored, shape) << edit.edit_id();
    EXPECT_TRUE(ids.insert(edit.edit_id()).second) << edit.edit_id() << " is there twice";
  }
}

// Drawing tile by tile, as the server does after a change, gives the same.
TEST_P(EditVectorFile, IsTheSameTileByTile) {
  ASSERT_OK_AND_ASSIGN(const EditVectors vectors, ReadEditVectors(GetParam()));
  edit::Overlay whole;
  std::set<grid::TileIndex> touched;
  for (const v1::MapEdit& edit : vectors.edits) {
    whole.Draw(ToCoreEdit(edit));
    touched.merge(edit::TilesOf(ToCoreEdit(edit).shape));
  }
  edit::Overlay pieces;
  for (const grid::TileIndex& index : touched) {
    const std::set<grid::TileIndex> only{index};
    for (const v1::MapEdit& edit : vectors.edits) {
      const edit::MapEdit drawn = ToCoreEdit(edit);
      if (edit::TilesOf(drawn.shape).contains(index)) pieces.Draw(drawn, &only);
    }
  }
  EXPECT_TRUE(pieces == whole);
}

}  // namespace
}  // namespace enfilade::testing
