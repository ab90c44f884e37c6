// SPDX-License-Identifier: Apache-2.0
#include "core/base/excerpt.h"

#include <gtest/gtest.h>

#include <string>

namespace enfilade {
namespace {

TEST(Excerpt, LeavesShortTextsAsTheyAre) {
  EXPECT_EQ(Excerpt("", 3), "");
  EXPECT_EQ(Excerpt("abc", 3), "abc");
  EXPECT_EQ(Excerpt("\u20ac", 3), "\u20ac");
}

TEST(Excerpt, CutsBetweenCharacters) {
  EXPECT_EQ(Excerpt("abcd", 3), "abc");
  const std::string text = "a\u00e9\u20ac\U0001f600z";  // of 1, 2, 3, 4 and 1 bytes
  const std::size_t ends[] = {0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10, 11};
  for (std::size_t most = 0; most < std::size(ends); ++most) {
    EXPECT_EQ(Excerpt(text, most), text.substr(0, ends[most])) << most;
  }
}

TEST(Excerpt, KeepsBytesThatAreNoCharacters) {
  const std::string bytes(10, '\x80');
  EXPECT_GE(Excerpt(bytes, 6).size(), 3u);
  EXPECT_LE(Excerpt(bytes, 6).size(), 6u);
}

}  // namespace
}  // namespace enfilade
