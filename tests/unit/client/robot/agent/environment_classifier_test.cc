// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/environment_classifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/simulator/sensors/sensors.h"
#include "client/sources/content.h"
#include "core/base/environment.h"
#include "tests/support/status_assertions.h"

namespace enfilade::robot {
namespace {

using ::testing::HasSubstr;

sensor::LaserScan RoundScan(float range) {
  sensor::LaserScan scan;
  scan.time = 1;
  scan.angle_min = -M_PI;
  scan.angle_increment = 2.0 * M_PI / 360.0;
  scan.range_min = 0.1F;
  scan.range_max = 100.0F;
  scan.ranges.assign(360, range);
  return scan;
}

// A depth image of a slope, with a stripe that moves by `shift`.
client::SpoolItem DepthAt(double seconds, int shift, sensor::Camera camera = sensor::Camera::kFront) {
  simulator::CameraFrame frame;
  frame.width = 64;
  frame.height = 48;
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      const bool stripe = (x + shift) / 4 % 2 == 0;
      frame.depth.push_back(static_cast<std::uint16_t>(stripe ? 1000 + 20 * y : 9000));
    }
  }
  std::string png = *frame.DepthPng();
  return {sensor::Image{static_cast<TimeNs>(seconds * 1e9), camera, sensor::ImageEncoding::kDepthPng16,
                        sources::RefOf(png)},
          png};
}

EnvironmentClassifier Made(int criterion) {
  EnvironmentOptions options;
  options.criterion = criterion;
  options.psnr_thr = 20.0;
  return *EnvironmentClassifier::Make(options);
}

TEST(EnvironmentClassifier, ByRange) {
  EnvironmentClassifier choice = Made(0);
  EXPECT_EQ(choice.Classify(0).environment, std::nullopt);
  EXPECT_THAT(choice.Classify(0).reason, HasSubstr("no scan"));
  choice.Add(RoundScan(5.0F));
  EXPECT_EQ(choice.Classify(0).environment, Environment::kIndoor);
  choice.Add(RoundScan(40.0F));
  EXPECT_EQ(choice.Classify(0).environment, Environment::kOutdoor);
  choice.Add(RoundScan(100.0F));
  EXPECT_EQ(choice.Classify(0).environment, std::nullopt) << "no hit";
}

TEST(EnvironmentClassifier, BySimilarityOfDepthImages) {
  for (const int criterion : {1, 2}) {
    EnvironmentClassifier still = Made(criterion);
    EnvironmentClassifier restless = Made(criterion);
    for (int i = 0; i < 5; ++i) {
      still.Add(DepthAt(i, 0));
      restless.Add(DepthAt(i, 4 * i));
    }
    EXPECT_EQ(still.Classify(0).environment, Environment::kIndoor) << still.Classify(0).reason;
    EXPECT_EQ(restless.Classify(0).environment, Environment::kOutdoor) << restless.Classify(0).reason;
  }
}

TEST(EnvironmentClassifier, LooksOnlyAtWhatCameSinceTheDoor) {
  EnvironmentClassifier choice = Made(1);
  for (int i = 0; i < 4; ++i) choice.Add(DepthAt(i, 4 * i));
  for (int i = 4; i < 8; ++i) choice.Add(DepthAt(i, 0));
  EXPECT_EQ(choice.Classify(4 * kNsPerSecond).environment, Environment::kIndoor);
}

TEST(EnvironmentClassifier, FallsBackOnTheRangeAndSaysSo) {
  EnvironmentClassifier choice = Made(1);
  choice.Add(RoundScan(40.0F));
  choice.Add(DepthAt(1.0, 0));
  choice.Add(DepthAt(2.0, 0, sensor::Camera::kRear));
  const EnvironmentClassifier::Verdict verdict = choice.Classify(0);
  EXPECT_EQ(verdict.environment, Environment::kOutdoor);
  EXPECT_THAT(verdict.reason, HasSubstr("config_criterion 1 cannot decide"));
}

TEST(EnvironmentClassifier, AMissingModelIsAnError) {
  EnvironmentOptions options;
  options.criterion = 3;
  options.scene_model = "missing.onnx";
  options.scene_labels = "missing.txt";
  options.scene_mapping = "missing.txt";
  EXPECT_STATUS(EnvironmentClassifier::Make(options).status(), absl::StatusCode::kNotFound, HasSubstr("missing"));
}

}  // namespace
}  // namespace enfilade::robot
