// SPDX-License-Identifier: Apache-2.0
#include "perception/environment/scene_classes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "fmt/format.h"
#include "tests/support/status_assertions.h"

namespace enfilade::perception {
namespace {

using ::testing::HasSubstr;

TEST(SceneClassesFormat, TakesThePlaces365FilesAsTheyAre) {
  ASSERT_OK_AND_ASSIGN(const auto classes,
                       ParseSceneClasses("/a/airfield 0\n/a/airplane_cabin 1\n/b/beach 48\n",
                                         "/a/airplane_cabin 1\n/b/beach 2\n/a/airfield 2\n/z/zen_garden 2\n"));
  ASSERT_EQ(classes.size(), 3U);
  EXPECT_EQ(classes[0].name, "/a/airfield");
  EXPECT_EQ(classes[0].environment, Environment::kOutdoor);
  EXPECT_EQ(classes[1].environment, Environment::kIndoor);
  EXPECT_EQ(classes[2].name, "/b/beach");
}

TEST(SceneClassesFormat, TakesWordsCommentsAndAnyLineEnds) {
  ASSERT_OK_AND_ASSIGN(const auto classes, ParseSceneClasses("# my classes\r\nhall\r\n\r\n  yard  \r\n",
                                                             "yard outdoor\r\n# a comment\r\nhall indoor\r\n"));
  ASSERT_EQ(classes.size(), 2U);
  EXPECT_EQ(classes[0].name, "hall");
  EXPECT_EQ(classes[0].environment, Environment::kIndoor);
  EXPECT_EQ(classes[1].environment, Environment::kOutdoor);
}

struct BadClasses {
  const char* labels;
  const char* mapping;
  const char* message;
};

void PrintTo(const BadClasses& bad, std::ostream* os) { *os << bad.message; }

class RefusedSceneClasses : public ::testing::TestWithParam<BadClasses> {};
INSTANTIATE_TEST_SUITE_P(
    SceneClasses, RefusedSceneClasses,
    ::testing::Values(BadClasses{"", "a 1\n", "no class"}, BadClasses{"# only a comment\n", "a 1\n", "no class"},
                      BadClasses{"a\n\na\n", "a 1\n", "labels, line 3: duplicate class a"},
                      BadClasses{"a\nb\n", "a 1\n", "labels, line 2: the class b is not in the mapping"},
                      BadClasses{"a\n", "a\n", "mapping, line 1"}, BadClasses{"a\n", "\n\na 0\n", "mapping, line 3"},
                      BadClasses{"a\n", "a Indoor\n", "expected a class and 1 (indoor) or 2 (outdoor)"},
                      BadClasses{"a\n", "a 12\n", "mapping, line 1"},
                      BadClasses{"a\n", "a 1\n# again\na 1\n", "mapping, line 3: duplicate class a"}));

TEST_P(RefusedSceneClasses, NameTheLine) {
  EXPECT_STATUS(ParseSceneClasses(GetParam().labels, GetParam().mapping), absl::StatusCode::kInvalidArgument,
                HasSubstr(GetParam().message));
}

TEST(SceneClassesFormat, KeepsTheOrderOfTheLabels) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<int> names(40);
    for (int i = 0; i < 40; ++i) names[static_cast<std::size_t>(i)] = i;
    std::string mapping;
    for (const int i : names) mapping += fmt::format("c{} {}\n", i, 1 + i % 2);
    std::shuffle(names.begin(), names.end(), random);
    std::string labels;
    for (const int i : names) labels += fmt::format("c{} {}\n", i, random() % 1000);
    ASSERT_OK_AND_ASSIGN(const auto classes, ParseSceneClasses(labels, mapping));
    ASSERT_EQ(classes.size(), names.size());
    for (std::size_t k = 0; k < names.size(); ++k) {
      EXPECT_EQ(classes[k].name, fmt::format("c{}", names[k]));
      EXPECT_EQ(classes[k].environment, names[k] % 2 == 0 ? Environment::kIndoor : Environment::kOutdoor);
    }
  }
}

}  // namespace
}  // namespace enfilade::perception
