// SPDX-License-Identifier: Apache-2.0
#include "client/robot/robot_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/status_assertions.h"

namespace enfilade::robot {
namespace {

using ::testing::HasSubstr;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

absl::StatusOr<RobotOptions> Parse(std::string_view yaml) { return ParseRobotOptions(yaml, RobotOptions{}); }

TEST(RobotOptions, WhatIsPrintedReadsBackTheSame) {
  for (const char* preset : {"default", "original-yaml", "original-code"}) {
    ASSERT_OK_AND_ASSIGN(RobotOptions options, RobotPreset(preset));
    options.evidence.images = 7;
    options.environment.scene_model = "a model.onnx";
    const std::string text = FormatRobotOptions(options);
    ASSERT_OK_AND_ASSIGN(const RobotOptions read, Parse(text));
    EXPECT_EQ(FormatRobotOptions(read), text);
    EXPECT_EQ(read.evidence.images, 7);
    EXPECT_EQ(read.environment.scene_model, "a model.onnx");
    EXPECT_EQ(read.doors.method, options.doors.method);
  }
}

TEST(RobotOptions, EveryOptionIsExplained) {
  std::string text = FormatRobotOptions(RobotOptions{});
  text = text.substr(0, text.find("# doors"));
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const std::string line = text.substr(begin, end - begin);
    if (line.back() == ':') continue;  // a group
    EXPECT_THAT(line, HasSubstr("  # "));
  }
}

TEST(RobotOptions, PresetsDifferAsMapManagersYamlAndCodeDo) {
  ASSERT_OK_AND_ASSIGN(const RobotOptions yaml, Parse("preset: original-yaml"));
  EXPECT_EQ(yaml.environment.range_thr, 13.0);
  EXPECT_EQ(yaml.environment.num_depth_imgs, 10);
  EXPECT_EQ(yaml.doors.derivative.threshold, 0.8);
  ASSERT_OK_AND_ASSIGN(const RobotOptions code, Parse("preset: original-code\nnum_depth_imgs: 6"));
  EXPECT_EQ(code.environment.range_thr, 10.0);
  EXPECT_EQ(code.environment.num_depth_imgs, 6);
  EXPECT_EQ(code.doors.derivative.threshold, 1.0);
  EXPECT_STATUS(Parse("range_thr: 9\npreset: best").status(), kInvalid, HasSubstr("line 2"));
}

TEST(RobotOptions, AcceptsMapManagersNames) {
  ASSERT_OK_AND_ASSIGN(const RobotOptions options,
                       Parse("preset: original-yaml\nderiv_door_thr: 0.9\ntime_limit_door_detection: 20\n"
                             "deriv_range_thr: 2.5\nlow_pass_filter_size_env: 55\ninitial_variance_theta: 0.01\n"
                             "num_last_imgs: 5\nuse_global_tracker: false\nrecord_imgs_and_pc: false"));
  EXPECT_EQ(options.doors.derivative.threshold, 0.9);
  EXPECT_EQ(options.doors.time_limit, 20.0);
  EXPECT_EQ(options.doors.environment.change, 2.5);
  EXPECT_EQ(options.doors.environment.filter_half_width, 55);
  EXPECT_EQ(options.initial_variance_theta, 0.01);
  EXPECT_EQ(options.evidence.images, 5);
  EXPECT_FALSE(options.use_global_tracker);
  EXPECT_FALSE(options.record_imgs_and_pc);
}

TEST(RobotOptions, RefusesWhatItDoesNotKnowWithTheLine) {
  EXPECT_STATUS(Parse("range_thr: 9\nrange_limit: 3").status(), kInvalid, HasSubstr("line 2"));
  EXPECT_STATUS(Parse("evidence:\n  all: 3").status(), kInvalid, HasSubstr("line 2"));
  EXPECT_STATUS(Parse("range_thr: far").status(), kInvalid, HasSubstr("expected a number"));
  EXPECT_STATUS(Parse("- 1").status(), kInvalid, HasSubstr("line 1"));
  EXPECT_STATUS(Parse("deriv_door_thr: 0.9\nderivative:\n  threshold: 0.8").status(), kInvalid,
                HasSubstr("is set twice"));
}

TEST(RobotOptions, RefusesMapManagersParametersThatTheServerHas) {
  for (const char* name : {"feature_matching_thr", "NNDR_akaze", "NNDR_sift", "icp_fitness_score_thr"}) {
    EXPECT_STATUS(Parse(std::string(name) + ": 1").status(), kInvalid, HasSubstr("on the server"));
  }
}

TEST(RobotOptions, RefusesValuesThatMakeNoSense) {
  for (const char* yaml :
       {"config_criterion: 4", "config_criterion: 3", "range_thr: -1", "range_thr: .nan", "low_pass_filter_size: -1",
        "num_depth_imgs: 1", "num_last_imgs: 0", "initial_variance_x: 0", "evidence: {kept: 2}",
        "evidence: {all_hz: -1}", "evidence: {max_age: 0}", "spool: {max_mib: 0}", "criteria: 4"}) {
    EXPECT_CODE(Parse(yaml).status(), kInvalid) << yaml;
  }
}

}  // namespace
}  // namespace enfilade::robot
