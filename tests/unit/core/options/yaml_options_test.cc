// SPDX-License-Identifier: Apache-2.0
#include "core/options/yaml_options.h"

#include <gtest/gtest.h>

#include "core/base/status_macros.h"
#include "tests/support/status_assertions.h"

namespace enfilade::yaml_options {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr auto kBadOption = absl::StatusCode::kInvalidArgument;

struct Sample {
  double size = 1.5;
  int count = 2;
  bool flag = false;
  std::string name = "plain";
  double inner_size = 0.25;
  int inner_count = 4;

  friend bool operator==(const Sample&, const Sample&) = default;
};

template <typename Options, typename Visitor>
void VisitSample(Options& options, const Visitor& visit) {
  visit("size", options.size);
  visit("count", options.count);
  visit("flag", options.flag);
  visit("name", options.name);
  visit("inner.size", options.inner_size);
  visit("inner.count", options.inner_count);
}

absl::StatusOr<Sample> ParseSample(std::string_view yaml, const std::set<std::string>& also_known = {}) {
  Sample sample;
  ENFILADE_ASSIGN_OR_RETURN(const Values values, Load(yaml, "sample"));
  ENFILADE_RETURN_IF_ERROR(Assign(
      values, "sample", [&](const auto& visitor) { VisitSample(sample, visitor); }, also_known));
  return sample;
}

TEST(YamlOptions, SetsWhatIsNamedAndKeepsTheRest) {
  ASSERT_OK_AND_ASSIGN(const Sample sample, ParseSample("size: 3\ninner:\n  count: 9\nflag: yes\nname: two words"));
  EXPECT_EQ(sample, (Sample{3.0, 2, true, "two words", 0.25, 9}));
  ASSERT_OK_AND_ASSIGN(const Sample same, ParseSample(""));
  EXPECT_EQ(same, Sample{});
  ASSERT_OK_AND_ASSIGN(const Sample commented, ParseSample("# nothing but a comment\n"));
  EXPECT_EQ(commented, Sample{});
}

TEST(YamlOptions, ReadsBackWhatItFormats) {
  const Sample changed{-0.1, 77, true, "x", 1e-9, -3};
  const std::string text = Format([&](const auto& visitor) { VisitSample(changed, visitor); });
  EXPECT_THAT(text, HasSubstr("inner:\n  size: 1e-09\n  count: -3\n"));
  ASSERT_OK_AND_ASSIGN(const Sample read, ParseSample(text));
  EXPECT_EQ(read, changed);
}

TEST(YamlOptions, RefusesWithTheLine) {
  for (const auto& [yaml, message] :
       {std::pair("size: 1\nsise: 2", "sample, line 2: there is no option sise"),
        std::pair("inner: {size: 1, sise: 2}", "sample, line 1: there is no option inner.sise"),
        std::pair("inner:\n  deep:\n    size: 1", "sample, line 3: there is no option inner.deep.size"),
        std::pair("inner.size: 2\ninner: {size: 3}", "sample, line 2: inner.size is set twice"),
        std::pair("size: 1\n\nsize: 2", "sample, line 3: size is set twice"),
        std::pair("inner: 3", "sample, line 1: there is no option inner"),
        std::pair("size: [1]", "sample, line 1: size is not a single value"),
        std::pair("count:", "sample, line 1: count is not a single value"),
        std::pair("- size", "sample, line 1: expected a mapping of options"),
        std::pair("size", "sample, line 1: expected a mapping of options"),
        std::pair("size: 1\n  count: 2", "sample, line 2: "), std::pair("size: {", "sample, line "),
        std::pair("size: big", "sample, line 1: size is \"big\", expected a number"),
        std::pair("count: 1.5", "sample, line 1: count is \"1.5\", expected a whole number"),
        std::pair("flag: 1", "sample, line 1: flag is \"1\", expected true or false")}) {
    EXPECT_STATUS(ParseSample(yaml), kBadOption, HasSubstr(message)) << yaml;
  }
}

TEST(YamlOptions, LeavesToTheCallerWhatItReadsItself) {
  EXPECT_OK(ParseSample("preset: fast\nsize: 2", {"preset"}));
  EXPECT_STATUS(ParseSample("preset: fast"), kBadOption, HasSubstr("there is no option preset"));
}

TEST(YamlOptions, LoadsNestedNamesWithTheirLines) {
  ASSERT_OK_AND_ASSIGN(const Values values, Load("a: 1\nb:\n  c: 2\n  d: {e: 3}\n", "sample"));
  std::vector<std::string> lines;
  for (const auto& [name, node] : values) lines.push_back(fmt::format("{}:{}", name, node.Mark().line + 1));
  EXPECT_THAT(lines, ElementsAre("a:1", "b.c:3", "b.d.e:4"));
}

TEST(Location, LeavesOutAnEmptySubject) {
  YAML::Mark mark;
  mark.line = 4;
  EXPECT_EQ(Location("options", mark), "options, line 5");
  EXPECT_EQ(Location("", mark), "line 5");
}

}  // namespace
}  // namespace enfilade::yaml_options
