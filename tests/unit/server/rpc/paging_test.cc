// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/paging.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
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

// Reads `rows` page by page, as a List RPC does: each page asks for the rows after the token's key, and one row more.
std::vector<std::string> ReadAll(const std::vector<std::string>& rows, int size, int* pages) {
  std::vector<std::string> read;
  std::string token;
  do {
    const auto after = FromPageToken(token);
    EXPECT_OK(after);
    std::vector<std::string> page;
    for (const std::string& row : rows) {
      if (row > *after && page.size() < static_cast<std::size_t>(size) + 1) page.push_back(row);
    }
    token = CutToPage(page, size) ? ToPageToken(page.back()) : "";
    read.insert(read.end(), page.begin(), page.end());
    ++*pages;
  } while (!token.empty());
  return read;
}

TEST(Paging, GivesEveryRowOnceWhateverThePageSize) {
  std::vector<std::string> rows;
  for (int count = 0; count <= 12; ++count) {
    for (int size = 1; size <= 13; ++size) {
      int pages = 0;
      EXPECT_EQ(ReadAll(rows, size, &pages), rows) << count << " rows, pages of " << size;
      EXPECT_EQ(pages, std::max(1, (count + size - 1) / size)) << "no empty page at the end";
    }
    rows.push_back("row-" + std::string(1, static_cast<char>('a' + count)));
  }
}

TEST(Paging, TokensAreOpaqueAndFitIntoAUrl) {
  for (const std::string key : {"a", "sites/s/maps/\xC3\xBC", "\n\t \"", "1699999999999999999/uuid"}) {
    const std::string token = ToPageToken(key);
    EXPECT_EQ(token.find(key), std::string::npos) << "nobody should build one by hand";
    EXPECT_EQ(token.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_="),
              std::string::npos)
        << token;
  }
}

TEST(Paging, NumericTokensHoldAnyNumber) {
  for (const std::int64_t key : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::int64_t{0},
                                 std::numeric_limits<std::int64_t>::max()}) {
    EXPECT_EQ(*FromNumericPageToken(ToPageToken(std::to_string(key)), 5), key);
  }
  EXPECT_STATUS(FromNumericPageToken(ToPageToken("9223372036854775808"), 0), absl::StatusCode::kInvalidArgument,
                ::testing::HasSubstr("page_token"));
  EXPECT_FALSE(FromNumericPageToken(ToPageToken(""), 0).ok());
}

}  // namespace
}  // namespace enfilade::server
