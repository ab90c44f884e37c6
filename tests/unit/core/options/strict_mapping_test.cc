// SPDX-License-Identifier: Apache-2.0
#include "core/options/strict_mapping.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <limits>

#include "tests/support/status_assertions.h"

namespace enfilade::yaml_options {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

// Reads `yaml` as a mapping called "thing" and gives its first error.
absl::Status Read(const std::string& yaml, const std::function<void(StrictMapping&)>& read) {
  return ReadYaml(yaml, "", [&](const YAML::Node& root) {
    absl::Status status;
    StrictMapping mapping(root, "thing", status);
    read(mapping);
    mapping.Finish();
    return status;
  });
}

TEST(StrictMapping, GivesTypedMembers) {
  EXPECT_OK(Read("{flag: true, count: -7, size: 1.5e2, name: 'a b', seed: 18446744073709551615}", [](auto& m) {
    EXPECT_TRUE(m.template Get<bool>("flag", false));
    EXPECT_EQ(m.template Get<int>("count", 0), -7);
    EXPECT_EQ(m.template Get<double>("size", 0.0), 150.0);
    EXPECT_EQ(m.template Required<std::string>("name"), "a b");
    EXPECT_EQ(m.template Get<std::uint64_t>("seed", 0), std::numeric_limits<std::uint64_t>::max());
  }));
}

TEST(StrictMapping, GivesTheFallbackForAMissingMember) {
  EXPECT_OK(Read("{}", [](auto& m) {
    EXPECT_EQ(m.template Get<int>("count", 3), 3);
    EXPECT_EQ(m.Number("size", 0.5, 0.0, 1.0), 0.5);
    EXPECT_EQ((m.template Choice<int>("kind", {{"one", 1}, {"two", 2}}, 2)), 2);
    EXPECT_FALSE(m.Has("count"));
    EXPECT_FALSE(m.Find("count").IsDefined());
    int visited = 0;
    m.Each("list", [&](const YAML::Node&) { ++visited; });
    EXPECT_EQ(visited, 0);
  }));
}

TEST(StrictMapping, ReadsListsAndChoices) {
  EXPECT_OK(Read("{kind: two, box: [1, -2.5, 3e2], list: [x, y]}", [](auto& m) {
    EXPECT_EQ((m.template Choice<int>("kind", {{"one", 1}, {"two", 2}}, 1)), 2);
    EXPECT_THAT(m.Numbers("box", 3), ElementsAre(1.0, -2.5, 300.0));
    std::vector<std::string> list;
    m.Each("list", [&](const YAML::Node& element) { list.push_back(element.Scalar()); });
    EXPECT_THAT(list, ElementsAre("x", "y"));
  }));
}

struct Refusal {
  const char* name;
  const char* yaml;
  std::function<void(StrictMapping&)> read;
  const char* message;
};

class StrictMappingRefusal : public ::testing::TestWithParam<Refusal> {};

TEST_P(StrictMappingRefusal, NamesLineMappingAndKey) {
  EXPECT_STATUS(Read(GetParam().yaml, GetParam().read), kInvalid, ::testing::StartsWith(GetParam().message));
}

void ReadNothing(StrictMapping&) {}

INSTANTIATE_TEST_SUITE_P(
    All, StrictMappingRefusal,
    ::testing::Values(Refusal{"List", "[1, 2]", ReadNothing, "line 1: thing is not a mapping"},
                      Refusal{"Scalar", "\n\nword", ReadNothing, "line 3: thing is not a mapping"},
                      Refusal{"Empty", "", ReadNothing, "line "}, Refusal{"Syntax", "a: 1\nb: [", ReadNothing, "line "},
                      Refusal{"UnknownKey", "a: 1\nb: 2", [](StrictMapping& m) { m.Get<int>("a", 0); },
                              "line 2: thing has no key \"b\""},
                      Refusal{"KeyThatIsAList", "? [a]\n: 1", ReadNothing, "line 1: thing has no key \"?\""},
                      Refusal{"TextForANumber", "a: far", [](StrictMapping& m) { m.Get<double>("a", 0.0); },
                              "line 1: thing.a is not a number"},
                      Refusal{"FractionForAnInteger", "\na: 1.5", [](StrictMapping& m) { m.Get<int>("a", 0); },
                              "line 2: thing.a is not a whole number"},
                      Refusal{"NumberForABool", "a: 3", [](StrictMapping& m) { m.Get<bool>("a", false); },
                              "line 1: thing.a is not true or false"},
                      Refusal{"ListForAText", "a: [b]", [](StrictMapping& m) { m.Get<std::string>("a", ""); },
                              "line 1: thing.a is not text"},
                      Refusal{"OverflowingInteger", "a: 4294967296", [](StrictMapping& m) { m.Get<int>("a", 0); },
                              "line 1: thing.a is not a whole number"},
                      Refusal{"TooLarge", "a: 1.1", [](StrictMapping& m) { m.Number("a", 0.0, 0.0, 1.0); },
                              "line 1: thing.a is 1.1: expected 0 to 1"},
                      Refusal{"TooSmall", "a: -0.1", [](StrictMapping& m) { m.Number("a", 0.0, 0.0, 1.0); },
                              "line 1: thing.a is -0.1: expected 0 to 1"},
                      Refusal{"NotFinite", "a: .nan", [](StrictMapping& m) { m.Number("a", 0.0, 0.0, 1.0); },
                              "line 1: thing.a is nan: expected 0 to 1"},
                      Refusal{"Missing", "\nb: 1",
                              [](StrictMapping& m) {
                                m.Get<int>("b", 0);
                                m.Required<int>("a");
                              },
                              "line 2: thing.a is missing"},
                      Refusal{"MissingNumbers", "{}", [](StrictMapping& m) { m.Numbers("a", 2); },
                              "line 1: thing.a is missing"},
                      Refusal{"TooFewNumbers", "a: [1]", [](StrictMapping& m) { m.Numbers("a", 2); },
                              "line 1: thing.a: expected 2 numbers"},
                      Refusal{"NumbersWithAWord", "a: [1, b]", [](StrictMapping& m) { m.Numbers("a", 2); },
                              "line 1: thing.a: expected 2 numbers"},
                      Refusal{"NumbersThatAreHuge", "a: [1, 1e6]", [](StrictMapping& m) { m.Numbers("a", 2); },
                              "line 1: thing.a: expected 2 numbers"},
                      Refusal{"NumbersThatAreNone", "a: [1, .inf]", [](StrictMapping& m) { m.Numbers("a", 2); },
                              "line 1: thing.a: expected 2 numbers"},
                      Refusal{"EachOfAScalar", "a: 1", [](StrictMapping& m) { m.Each("a", [](const YAML::Node&) {}); },
                              "line 1: thing.a is not a list"},
                      Refusal{"UnknownChoice", "a: three",
                              [](StrictMapping& m) {
                                m.Choice<int>("a", {{"one", 1}, {"two", 2}}, 1);
                              },
                              "line 1: thing.a is \"three\": expected one, two"},
                      Refusal{"ChoiceThatIsAList", "a: [one]",
                              [](StrictMapping& m) {
                                m.Choice<int>("a", {{"one", 1}}, 1);
                              },
                              "line 1: thing.a is not text"}),
    [](const auto& param) { return param.param.name; });

TEST(StrictMapping, KeepsTheFirstErrorOfADocument) {
  EXPECT_STATUS(Read("a: x\nb: y\nc: 1",
                     [](auto& m) {
                       EXPECT_EQ(m.template Get<int>("a", 5), 5);
                       EXPECT_EQ(m.template Get<int>("b", 6), 6);
                       EXPECT_EQ(m.template Get<int>("c", 7), 1) << "what is right is still read";
                     }),
                kInvalid, HasSubstr("line 1: thing.a"));
}

TEST(StrictMapping, SharesTheErrorBetweenMappings) {
  const absl::Status status = ReadYaml("inner: {a: x}\nouter: y", "", [](const YAML::Node& root) {
    absl::Status shared;
    StrictMapping outer(root, "outer", shared);
    StrictMapping inner(outer.Find("inner"), "inner", shared);
    inner.Get<int>("a", 0);
    outer.Get<int>("outer", 0);
    return shared;
  });
  EXPECT_STATUS(status, kInvalid, HasSubstr("inner.a"));
}

TEST(ReadYaml, TurnsExceptionsOfTheReaderIntoStatuses) {
  const absl::Status status = ReadYaml("a: 1\nb: word", "a file", [](const YAML::Node& root) {
    root["b"].as<int>();
    return absl::OkStatus();
  });
  EXPECT_STATUS(status, kInvalid, ::testing::StartsWith("a file, line 2: "));
}

}  // namespace
}  // namespace enfilade::yaml_options
