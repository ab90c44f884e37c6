// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/paging.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

TEST(Paging, TokensGiveTheKeyBackAndOthersAreRefused) {
  for (const std::string key : {"a", "map-1", "17", "x/y z"}) {
    ASSERT_OK_AND_ASSIGN(const std::string back, FromPageToken(ToPageToken(key)));
    EXPECT_EQ(back, key);
  }
  EXPECT_EQ(*FromPageToken(""), "");
  for (const char* token : {"garbage", "cDI6eA", "!"}) EXPECT_FALSE(FromPageToken(token).ok()) << token;
  EXPECT_EQ(*FromNumericPageToken("", -1), -1);
  EXPECT_EQ(*FromNumericPageToken(ToPageToken("17"), -1), 17);
  EXPECT_FALSE(FromNumericPageToken(ToPageToken("17x"), -1).ok());
}

TEST(Paging, SizesAreBounded) {
  EXPECT_EQ(*PageSize(0), 100);
  EXPECT_EQ(*PageSize(7), 7);
  EXPECT_EQ(*PageSize(100'000), 1000);
  EXPECT_FALSE(PageSize(-1).ok());
  std::vector<int> rows{1, 2, 3};
  EXPECT_TRUE(CutToPage(rows, 2));
  EXPECT_EQ(rows.size(), 2U);
  EXPECT_FALSE(CutToPage(rows, 2));
}

}  // namespace
}  // namespace enfilade::server
