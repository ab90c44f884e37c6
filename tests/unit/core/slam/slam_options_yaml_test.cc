// SPDX-License-Identifier: Apache-2.0
#include "core/slam/slam_options_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "core/slam/slam_option_names.h"
#include "fmt/format.h"
#include "tests/support/status_assertions.h"

namespace enfilade::slam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr auto kBad = absl::StatusCode::kInvalidArgument;

TEST(SlamOptionsYaml, NamesWhatIsSetAndKeepsTheRest) {
  ASSERT_OK_AND_ASSIGN(const SlamOptions options,
                       ParseSlamOptions("max_range: 12.5\noccupancy: {log_odds: false}\nloop:\n  max_attempts: 3\n"));
  EXPECT_EQ(options.max_range, 12.5);
  EXPECT_FALSE(options.occupancy.log_odds);
  EXPECT_EQ(options.loop.max_attempts, 3);
  EXPECT_EQ(options.resolution, SlamOptions{}.resolution);
  EXPECT_OK(ParseSlamOptions(""));
}

TEST(SlamOptionsYaml, RefusesWhatItDoesNotKnow) {
  EXPECT_STATUS(ParseSlamOptions("max_range: 3\nloop: {driftt: 1}"), kBad,
                HasSubstr("line 2: there is no option loop.driftt"));
  EXPECT_STATUS(ParseSlamOptions("max_range: far"), kBad, HasSubstr("max_range is \"far\", expected a number"));
  EXPECT_STATUS(ParseSlamOptions("loop: {max_attempts: 1.5}"), kBad, HasSubstr("expected a whole number"));
  EXPECT_STATUS(ParseSlamOptions("match_scans: 3"), kBad, HasSubstr("expected true or false"));
  EXPECT_STATUS(ParseSlamOptions("max_range: 3\nmax_range: 4"), kBad, HasSubstr("max_range is set twice"));
  EXPECT_STATUS(ParseSlamOptions("max_range: [3]"), kBad, HasSubstr("not a single value"));
  EXPECT_STATUS(ParseSlamOptions("- 3"), kBad, HasSubstr("expected a map"));
  EXPECT_STATUS(ParseSlamOptions("loop: {"), kBad, HasSubstr("slam options"));
  EXPECT_STATUS(ParseSlamOptions("resolution: .nan"), kBad, HasSubstr("slam.resolution"));
}

TEST(SlamOptionsYaml, BeginsItsMessagesWithTheName) {
  EXPECT_STATUS(ParseSlamOptions("max_rang: 3", "/etc/slam.yaml"), kBad,
                AllOf(::testing::StartsWith("/etc/slam.yaml"), HasSubstr("max_rang")));
  EXPECT_STATUS(ParseSlamOptions("resolution: 7", "hall.yaml"), kBad, ::testing::StartsWith("hall.yaml"));
  EXPECT_OK(ParseSlamOptions("resolution: 0.1", "hall.yaml"));
}

struct Limited {
  const char* name;
  double low;
  double high;
};

// One step beyond either limit is refused, the limit itself is not.
TEST(SlamOptionsYaml, AcceptsOptionsUpToTheirLimits) {
  for (const Limited& option :
       {Limited{"resolution", 0.005, 1.0}, Limited{"max_range", 0.5, 200.0}, Limited{"keyframe.angle", 0.01, M_PI},
        Limited{"pyramid.levels", 1, 6}, Limited{"submap.max_keyframes", 2, 10'000},
        Limited{"local.max_half_width", 0.05, 10.0}, Limited{"occupancy.no_return_range", 0.0, 200.0},
        Limited{"loop.max_ambiguity", 0, 1}, Limited{"graph.growth", 0.0, 10.0}}) {
    const std::string name = option.name;
    const bool whole = name == "pyramid.levels" || name == "submap.max_keyframes";
    const auto with = [&](double value) {
      const std::size_t dot = name.find('.');
      const std::string written = fmt::format("{}", value);
      return ParseSlamOptions(dot == std::string::npos
                                  ? name + ": " + written
                                  : name.substr(0, dot) + ": {" + name.substr(dot + 1) + ": " + written + "}");
    };
    const double step = whole ? 1.0 : 1e-3;
    EXPECT_OK(with(option.low)) << name;
    EXPECT_OK(with(option.high)) << name;
    EXPECT_STATUS(with(option.low - step), kBad, HasSubstr("slam." + name));
    EXPECT_STATUS(with(option.high + step), kBad, HasSubstr("slam." + name));
  }
}

TEST(SlamOptionsYaml, RefusesProbabilitiesThatContradictOneAnother) {
  EXPECT_STATUS(ParseSlamOptions("occupancy: {min_probability: 0.42}"), kBad, HasSubstr("miss_probability"));
  EXPECT_STATUS(ParseSlamOptions("occupancy: {max_probability: 0.6}"), kBad, HasSubstr("hit_probability"));
  EXPECT_STATUS(ParseSlamOptions("occupancy: {hit_probability: 0.5}"), kBad, HasSubstr("0.501"));
}

TEST(SlamOptionsYaml, ReadsBackAllThatItWrites) {
  SlamOptions changed;
  int i = 0;
  VisitSlamOptions(changed, [&](const char*, auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, bool>) {
      value = !value;
    } else if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
      value *= 1.0 + 1e-4 * ++i;
    }
  });
  ASSERT_OK_AND_ASSIGN(const SlamOptions read, ParseSlamOptions(FormatSlamOptions(changed)));
  EXPECT_EQ(FormatSlamOptions(read), FormatSlamOptions(changed));
  EXPECT_FALSE(read.match_scans);
}

// A new option without limits would take NaN.
TEST(SlamOptions, RefusesNonsenseInEveryOption) {
  int options_seen = 0;
  const SlamOptions defaults;
  VisitSlamOptions(defaults, [&](const std::string& name, const auto& default_value) {
    using T = std::decay_t<decltype(default_value)>;
    if constexpr (!std::is_same_v<T, bool>) {
      SlamOptions options;
      VisitSlamOptions(options, [&](const std::string& other, auto& value) {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
          if (other == name) value = std::numeric_limits<double>::quiet_NaN();
        } else if constexpr (std::is_same_v<std::decay_t<decltype(value)>, int>) {
          if (other == name) value = -1;
        }
      });
      EXPECT_STATUS(options.Validate(), kBad, HasSubstr(name.c_str()));
    }
    ++options_seen;
  });
  EXPECT_GT(options_seen, 60);
  EXPECT_OK(SlamOptions{}.Validate());
}

}  // namespace
}  // namespace enfilade::slam
