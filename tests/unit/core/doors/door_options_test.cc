// SPDX-License-Identifier: Apache-2.0
#include "core/doors/door_options.h"

#include <gtest/gtest.h>

#include "tests/support/status_assertions.h"

namespace enfilade::doors {
namespace {

using ::testing::HasSubstr;

TEST(DoorOptions, PresetsHoldBothPublishedParameterSetsOfMapManager) {
  ASSERT_OK_AND_ASSIGN(const DoorOptions yaml, DoorPreset("original-yaml"));
  ASSERT_OK_AND_ASSIGN(const DoorOptions code, DoorPreset("original-code"));
  EXPECT_EQ(yaml.derivative.threshold, 0.8);
  EXPECT_EQ(code.derivative.threshold, 1.0);
  EXPECT_EQ(yaml.environment.filter_half_width, 60);
  EXPECT_EQ(code.environment.filter_half_width, 50);
  for (const DoorOptions& options : {yaml, code}) {
    EXPECT_EQ(options.method, DoorMethod::kDerivative);
    EXPECT_EQ(options.criteria, 2);
    EXPECT_EQ(options.time_limit, 15.0);
    EXPECT_EQ(options.candidate_spacing, 2.0);
    EXPECT_EQ(options.derivative.hits, 3);
    EXPECT_EQ(options.derivative.front_window, 3.0);
    EXPECT_EQ(options.derivative.min_distance, 1.5);
    EXPECT_EQ(options.derivative.max_distance, 5.0);
    EXPECT_EQ(options.derivative.max_heading, 30.0);
    EXPECT_EQ(options.environment.change, 2.0);
    EXPECT_EQ(options.environment.interval, 3.0);
    EXPECT_EQ(options.environment.outdoor_guard, 10.0);
  }
  EXPECT_STATUS(DoorPreset("best"), absl::StatusCode::kInvalidArgument, HasSubstr("original-code"));
}

TEST(DoorOptions, EveryPresetIsValidAndReadsBackFromItsText) {
  for (const std::string& name : DoorPresetNames()) {
    ASSERT_OK_AND_ASSIGN(const DoorOptions options, DoorPreset(name));
    ASSERT_OK(options.Validate());
    const std::string text = FormatDoorOptions(options);
    ASSERT_OK_AND_ASSIGN(const DoorOptions again, ParseDoorOptions(text, DoorOptions{}));
    EXPECT_EQ(FormatDoorOptions(again), text);
    EXPECT_EQ(again.method, options.method);
  }
}

TEST(DoorOptions, RefusesUnknownKeysAndBadValuesWithTheLine) {
  const auto refused = [](const char* yaml, const char* message) {
    EXPECT_STATUS(ParseDoorOptions(yaml, {}), absl::StatusCode::kInvalidArgument, HasSubstr(message));
  };
  refused("gap:\n  max_widht: 2\n", "line 2: there is no option gap.max_widht");
  refused("gap: {hits: many}", "gap.hits is \"many\"");
  refused("gap: {hits: [1]}", "not a single value");
  refused("criteria: 4", "criteria is 4");
  refused("time_limit: -1", "time_limit is -1");
  refused("gap: {cell: 0}", "gap.cell");
  refused("gap: {look_ahead: 9}", "beyond gap.reach");
  refused("preset: mine", "no preset \"mine\"");
  refused(": [", "door options");
}

}  // namespace
}  // namespace enfilade::doors
