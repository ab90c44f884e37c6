// SPDX-License-Identifier: Apache-2.0
#include "perception/environment/frame_similarity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/environment.h"
#include "tests/support/status_assertions.h"

namespace enfilade::perception {
namespace {

using ::testing::HasSubstr;

GreyFrame Flat(std::uint8_t value, int width = 64, int height = 48) {
  return {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), value)};
}

GreyFrame Noise(std::uint32_t seed) {
  std::mt19937 rng(seed);
  GreyFrame frame = Flat(0);
  for (std::uint8_t& pixel : frame.pixels) pixel = static_cast<std::uint8_t>(rng() % 256);
  return frame;
}

// A floor that rises away from the camera, with noise of `deviation` m.
DepthFrame Depth(std::uint32_t seed, double deviation) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise(0.0, deviation);
  DepthFrame frame{64, 48, {}};
  for (int row = 0; row < 48; ++row) {
    for (int column = 0; column < 64; ++column) {
      const double metres = 2.0 + 0.1 * row + (column / 16 % 2 == 0 ? 0.0 : 1.0);
      frame.metres.push_back(static_cast<float>(std::max(0.0, metres + noise(rng))));
    }
  }
  return frame;
}

TEST(StructuralSimilarityTest, IsOneForEqualImages) {
  EXPECT_NEAR(StructuralSimilarity(Noise(1), Noise(1)).value(), 1.0, 1e-12);
  EXPECT_NEAR(StructuralSimilarity(Flat(0), Flat(0)).value(), 1.0, 1e-12);
}

// Without structure only the means count: (2 a b + C1) / (a^2 + b^2 + C1).
TEST(StructuralSimilarityTest, FollowsItsFormulaOnFlatImages) {
  const double expected = (2.0 * 100.0 * 150.0 + 6.5025) / (100.0 * 100.0 + 150.0 * 150.0 + 6.5025);
  EXPECT_NEAR(StructuralSimilarity(Flat(100), Flat(150)).value(), expected, 1e-9);
  EXPECT_NEAR(StructuralSimilarity(Flat(0), Flat(255)).value(), 6.5025 / (65025.0 + 6.5025), 1e-9);
}

TEST(StructuralSimilarityTest, IsNearZeroForUnrelatedNoise) {
  EXPECT_NEAR(StructuralSimilarity(Noise(1), Noise(2)).value(), 0.0, 0.05);
}

TEST(PeakSignalToNoiseTest, FollowsItsFormula) {
  EXPECT_NEAR(PeakSignalToNoise(Flat(100), Flat(110)).value(), 20.0 * std::log10(255.0 / 10.0), 1e-9);
  EXPECT_NEAR(PeakSignalToNoise(Flat(0), Flat(255)).value(), 0.0, 1e-9);
}

// Not 0 dB, which would be the lowest similarity.
TEST(PeakSignalToNoiseTest, IsInfiniteForEqualImages) {
  EXPECT_TRUE(std::isinf(PeakSignalToNoise(Noise(3), Noise(3)).value()));
  const std::vector<DepthFrame> standing(5, Depth(1, 0.0));
  const SimilarityCriterion criterion{.measure = SimilarityMeasure::kPsnr, .threshold = 20.0};
  ASSERT_OK_AND_ASSIGN(const SimilarityChoice choice, ChooseBySimilarity(standing, criterion));
  EXPECT_EQ(choice.environment, Environment::kIndoor);
}

TEST(FrameSimilarityTest, RefusesImagesOfDifferentSizes) {
  EXPECT_STATUS(StructuralSimilarity(Flat(1), Flat(1, 48, 64)), absl::StatusCode::kInvalidArgument,
                HasSubstr("64x48 and 48x64"));
  EXPECT_STATUS(PeakSignalToNoise(Flat(1), {2, 2, {1}}), absl::StatusCode::kInvalidArgument, HasSubstr("2x2"));
  EXPECT_NEAR(StructuralSimilarity(Flat(7, 1, 1), Flat(7, 1, 1)).value(), 1.0, 1e-12);
}

TEST(BrightnessOfTest, ScalesDepthAndBlackensMissingMeasurements) {
  const GreyFrame grey = BrightnessOf({5, 1, {0.0F, 5.0F, 20.0F, NAN, INFINITY}}, 10.0);
  EXPECT_THAT(std::vector<int>(grey.pixels.begin(), grey.pixels.end()), ::testing::ElementsAre(0, 128, 255, 0, 0));
}

TEST(ChooseBySimilarityTest, TakesUnlikeDepthImagesForOutdoors) {
  std::vector<DepthFrame> steady;
  std::vector<DepthFrame> unsteady;
  for (std::uint32_t seed = 0; seed < 12; ++seed) {
    steady.push_back(Depth(seed, 0.005));
    unsteady.push_back(Depth(seed, 2.0));
  }
  ASSERT_OK_AND_ASSIGN(const SimilarityChoice indoor, ChooseBySimilarity(steady));
  ASSERT_OK_AND_ASSIGN(const SimilarityChoice outdoor, ChooseBySimilarity(unsteady));
  EXPECT_EQ(indoor.environment, Environment::kIndoor);
  EXPECT_EQ(indoor.pairs, 9);  // of the 10 frames asked for
  EXPECT_EQ(outdoor.environment, Environment::kOutdoor);
  EXPECT_LT(outdoor.mean, 0.4);
}

TEST(ChooseBySimilarityTest, NeedsTwoFrames) {
  const std::vector<DepthFrame> one(1, Depth(1, 0.0));
  EXPECT_STATUS(ChooseBySimilarity(one), absl::StatusCode::kInvalidArgument, HasSubstr("at least 2"));
}

}  // namespace
}  // namespace enfilade::perception
