// SPDX-License-Identifier: Apache-2.0
#include "core/slam/slam_options_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "core/slam/slam_option_names.h"
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
