// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/submap_cache.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/slam/submaps/robot_rays.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

// A submap that has seen one box of a size of its own.
FinishedSubmap BoxOf(double side) {
  const double h = side / 2.0;
  const std::vector<testing::Wall> walls{
      {{-h, -h}, {h, -h}}, {{h, -h}, {h, h}}, {{h, h}, {-h, h}}, {{-h, h}, {-h, -h}}};
  SubmapContent content{{}, {}, {}, SubmapGrid(0.05, {})};
  const testing::SyntheticScanner all_around{.beams = 180, .field_of_view = 6.28};
  EXPECT_OK(content.grid.Insert({}, RobotRays(testing::Scan(walls, {}, all_around, 0, 1), {})));
  return FinishSubmap({}, 1, Encode(content), {}, std::nullopt);
}

class SubmapCacheTest : public ::testing::Test {
 protected:
  SubmapCacheTest() {
    options_.loop.cached_submaps = 2;
    for (int i = 0; i < 4; ++i) submaps_.push_back(BoxOf(2.0 + i));
  }

  const SearchableSubmap& Get(SubmapCache& cache, std::int64_t id) const {
    return cache.Get(id, submaps_.at(static_cast<std::size_t>(id)));
  }

  SlamOptions options_;
  std::vector<FinishedSubmap> submaps_;
};

TEST_F(SubmapCacheTest, GivesTheSubmapsGridAndItsPyramid) {
  SubmapCache cache(options_);
  const SearchableSubmap& submap = Get(cache, 1);
  ASSERT_OK_AND_ASSIGN(const SubmapContent content, DecodeSubmapContent(submaps_[1].content, {}));
  EXPECT_TRUE(submap.grid == content.grid);
  const FieldPyramid expected(content.grid, options_.pyramid);
  ASSERT_EQ(submap.pyramid.levels.size(), expected.levels.size());
  for (std::size_t i = 0; i < expected.levels.size(); ++i) {
    EXPECT_EQ(submap.pyramid.levels[i].squared_distances(), expected.levels[i].squared_distances());
  }
}

TEST_F(SubmapCacheTest, KeepsTheSubmapsUsedLast) {
  SubmapCache cache(options_);
  const SearchableSubmap* first = &Get(cache, 0);
  Get(cache, 1);
  EXPECT_EQ(&Get(cache, 0), first) << "still there, and now the last used";
  Get(cache, 2);  // in place of 1
  EXPECT_EQ(&Get(cache, 0), first);
  const std::size_t with_two = cache.bytes();
  Get(cache, 1);  // in place of 2
  EXPECT_EQ(&Get(cache, 0), first);
  EXPECT_LT(cache.bytes(), with_two) << "the box of 1 is smaller than that of 2";
}

TEST_F(SubmapCacheTest, HoldsNoMoreThanItsLimit) {
  SubmapCache cache(options_);
  EXPECT_EQ(cache.bytes(), 0U);
  std::vector<std::size_t> alone;
  for (std::int64_t id = 0; id < 4; ++id) {
    SubmapCache one(options_);
    Get(one, id);
    alone.push_back(one.bytes());
    Get(cache, id);
    const std::size_t before = id > 0 ? alone[static_cast<std::size_t>(id) - 1] : 0;
    EXPECT_EQ(cache.bytes(), alone.back() + before) << "the last two";
  }
}

TEST_F(SubmapCacheTest, KeepsMoreIfThereIsRoom) {
  SubmapCache all(options_, 1U << 30U);
  for (std::int64_t id = 0; id < 4; ++id) Get(all, id);
  const std::size_t bytes = all.bytes();
  SubmapCache cache(options_, bytes);
  const SearchableSubmap* first = &Get(cache, 0);
  for (std::int64_t id = 1; id < 4; ++id) Get(cache, id);
  EXPECT_EQ(cache.bytes(), bytes);
  EXPECT_EQ(&Get(cache, 0), first);
  SubmapCache smaller(options_, bytes - 1);
  for (std::int64_t id = 0; id < 4; ++id) Get(smaller, id);
  SubmapCache without_first(options_, 1U << 30U);
  for (std::int64_t id = 1; id < 4; ++id) Get(without_first, id);
  EXPECT_EQ(smaller.bytes(), without_first.bytes());
}

TEST_F(SubmapCacheTest, KeepsGridsIfThereIsRoom) {
  SubmapCache cache(options_, 1U << 30U);
  const SubmapGrid* two = &cache.GetGrid(2, submaps_[2]);
  cache.GetGrid(3, submaps_[3]);
  EXPECT_EQ(&cache.GetGrid(2, submaps_[2]), two);
  SubmapCache one(options_);
  one.GetGrid(2, submaps_[2]);
  const std::size_t bytes = one.bytes();
  one.GetGrid(3, submaps_[3]);
  one.GetGrid(2, submaps_[2]);
  EXPECT_EQ(one.bytes(), bytes);
}

TEST_F(SubmapCacheTest, GivesGridsAlone) {
  SubmapCache cache(options_);
  const SubmapGrid decoded = DecodeSubmapContent(submaps_[3].content, {})->grid;
  const SubmapGrid* three = &cache.GetGrid(3, submaps_[3]);
  EXPECT_TRUE(*three == decoded);
  EXPECT_LT(cache.bytes(), 2 * decoded.bytes()) << "without a pyramid";
  EXPECT_EQ(&cache.GetGrid(3, submaps_[3]), three) << "still there";
  const SearchableSubmap& searchable = Get(cache, 1);
  EXPECT_EQ(&cache.GetGrid(1, submaps_[1]), &searchable.grid);
}

TEST_F(SubmapCacheTest, NeedNotDecompressGridsThatWerePut) {
  SubmapCache cache(options_);
  FinishedSubmap lost = submaps_[0];
  lost.content.clear();  // cannot be decompressed
  const SubmapGrid grid = DecodeSubmapContent(submaps_[0].content, {})->grid;
  cache.Put(0, grid);
  EXPECT_TRUE(cache.GetGrid(0, lost) == grid);
  EXPECT_TRUE(cache.Get(0, lost).grid == grid);
  SubmapCache grids(options_, 2);
  std::size_t with_two = 0;
  for (const std::int64_t id : {0, 1, 2, 3}) {
    grids.Put(id, grid);
    if (id == 1) with_two = grids.bytes();
  }
  EXPECT_EQ(grids.bytes(), with_two) << "no more than asked for";
}

// Checkpoints do not hold the cache: results must not depend on what is in it.
TEST_F(SubmapCacheTest, GivesTheSameWhateverWasAskedBefore) {
  SubmapCache used(options_);
  for (const std::int64_t id : {3, 0, 2, 1, 2, 0, 3}) {
    SubmapCache fresh(options_);
    const SearchableSubmap& a = Get(used, id);
    const SearchableSubmap& b = Get(fresh, id);
    EXPECT_TRUE(a.grid == b.grid);
    for (std::size_t i = 0; i < a.pyramid.levels.size(); ++i) {
      EXPECT_EQ(a.pyramid.levels[i].squared_distances(), b.pyramid.levels[i].squared_distances());
    }
  }
}

}  // namespace
}  // namespace enfilade::slam
