// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

#include "core/graph/cow_index.h"
#include "core/graph/cow_vector.h"

namespace enfilade::graph {
namespace {

// Random changes of several versions, each made from an earlier one; every version must keep its own content.
TEST(CowVector, EveryVersionKeepsItsContent) {
  std::mt19937 random(1);
  std::vector<CowVector<int, 4>> versions(1);
  std::vector<std::vector<int>> expected(1);
  versions[0].Freeze();
  for (int step = 0; step < 60; ++step) {
    const std::size_t from = random() % versions.size();
    CowVector<int, 4> next = versions[from];
    std::vector<int> content = expected[from];
    for (std::uint32_t change = random() % 10; change > 0; --change) {
      const int value = static_cast<int>(random() % 1000);
      if (content.empty() || random() % 3 == 0) {
        next.Append() = value;
        content.push_back(value);
      } else {
        const std::size_t at = random() % content.size();
        next.Mutable(at) = value;
        content[at] = value;
      }
    }
    next.Freeze();
    versions.push_back(next);
    expected.push_back(content);
    for (std::size_t v = 0; v < versions.size(); ++v) {
      ASSERT_EQ(versions[v].size(), expected[v].size());
      for (std::size_t i = 0; i < expected[v].size(); ++i) ASSERT_EQ(versions[v][i], expected[v][i]) << v;
    }
  }
}

TEST(CowVector, ACopySharesUnchangedChunks) {
  CowVector<std::string, 2> first;
  for (const char* text : {"a", "b", "c", "d"}) first.Append() = text;
  first.Freeze();
  CowVector<std::string, 2> second = first;
  second.Mutable(3) = "x";
  second.Freeze();
  EXPECT_EQ(&first[0], &second[0]) << "shared";
  EXPECT_EQ(&first[1], &second[1]) << "shared";
  EXPECT_NE(&first[2], &second[2]) << "in the chunk that changed";
  EXPECT_EQ(first[3], "d");
  EXPECT_EQ(second[3], "x");
}

TEST(CowVector, AppendingLeavesTheOriginalsLastChunkAlone) {
  CowVector<int, 4> first;
  first.Append() = 1;
  first.Freeze();
  CowVector<int, 4> second = first;
  second.Append() = 2;
  second.Freeze();
  CowVector<int, 4> third = first;
  third.Append() = 3;
  EXPECT_EQ(first.size(), 1U);
  EXPECT_EQ(second[1], 2);
  EXPECT_EQ(third[1], 3);
}

TEST(CowIndex, AgreesWithAMapOverManyVersions) {
  std::mt19937 random(2);
  CowIndex<std::string> index;
  std::map<std::string, int> expected;
  std::vector<std::pair<CowIndex<std::string>, std::map<std::string, int>>> versions;
  for (int step = 0; step < 4000; ++step) {
    const std::string key = "k" + std::to_string(random() % 700);
    if (expected.contains(key)) {
      index.Erase(key);
      expected.erase(key);
    } else {
      index.Insert(key, step);
      expected[key] = step;
    }
    if (step % 500 == 0) {
      index.Freeze();
      versions.emplace_back(index, expected);
    }
  }
  versions.emplace_back(index, expected);
  for (const auto& [version, content] : versions) {
    EXPECT_EQ(version.size(), content.size());
    for (int k = 0; k < 700; ++k) {
      const std::string key = "k" + std::to_string(k);
      const auto found = content.find(key);
      EXPECT_EQ(version.Find(key), found == content.end() ? -1 : found->second);
    }
  }
}

}  // namespace
}  // namespace enfilade::graph
