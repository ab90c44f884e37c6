// SPDX-License-Identifier: Apache-2.0
#include "core/localization/searchable_map.h"

#include "gtest/gtest.h"
#include "tests/unit/core/localization/drawn_map.h"

namespace enfilade::localization {
namespace {

TEST(SearchableMapTest, KnowsWallsGroundAndWhatIsUnknown) {
  const DrawnMap drawn({"########",  //
                        "#  ????#",  //
                        "#  ????#",  //
                        "########"});
  const auto map = drawn.Searchable();
  EXPECT_EQ(map->At({0.1, 0.1}), SearchableMap::Cell::kOccupied);
  EXPECT_EQ(map->At({0.4, 0.4}), SearchableMap::Cell::kFree);
  EXPECT_EQ(map->At({1.4, 0.4}), SearchableMap::Cell::kUnknown);
  EXPECT_EQ(map->At({-5.0, 1e12}), SearchableMap::Cell::kUnknown);
  EXPECT_FALSE(map->empty());
  EXPECT_TRUE(map->HasGround({{4, 4}, 1, 1}));
  EXPECT_TRUE(map->HasGround({{0, 0}, 20, 10}));
  EXPECT_FALSE(map->HasGround({{14, 4}, 2, 2})) << "1.4 m to the right nothing is known to be free";
  EXPECT_FALSE(map->HasGround({{500, 500}, 100, 100}));
  EXPECT_GT(map->bytes(), 1000U);
}

TEST(SearchableMapTest, WithoutWallsOrGroundThereIsNothingToSearch) {
  EXPECT_TRUE(DrawnMap({"????", "????"}).Searchable()->empty());
  EXPECT_TRUE(DrawnMap({"    ", "    "}).Searchable()->empty());
  EXPECT_TRUE(DrawnMap({"####", "####"}).Searchable()->empty());
}

}  // namespace
}  // namespace enfilade::localization
