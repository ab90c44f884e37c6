// SPDX-License-Identifier: Apache-2.0
// Similarity of images by its definitions, on random images.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "perception/environment/frame_similarity.h"
#include "tests/support/status_assertions.h"

namespace enfilade::perception {
namespace {

using ::testing::HasSubstr;

GreyFrame RandomGrey(std::mt19937& random, int width, int height) {
  GreyFrame frame{width, height, {}};
  for (int i = 0; i < width * height; ++i) frame.pixels.push_back(static_cast<std::uint8_t>(random()));
  return frame;
}

class SimilaritySeeds : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Images, SimilaritySeeds, ::testing::Range(1U, 9U));

TEST_P(SimilaritySeeds, BothMeasuresAreSymmetricAndFallWithNoise) {
  std::mt19937 random(GetParam());
  const GreyFrame image = RandomGrey(random, 40, 30);
  double last_ssim = 1.0;
  double last_psnr = std::numeric_limits<double>::infinity();
  for (const int amplitude : {2, 16, 64}) {
    GreyFrame noisy = image;
    for (std::uint8_t& pixel : noisy.pixels) {
      const int noise = static_cast<int>(random() % static_cast<unsigned>(2 * amplitude + 1)) - amplitude;
      pixel = static_cast<std::uint8_t>(std::clamp(pixel + noise, 0, 255));
    }
    ASSERT_OK_AND_ASSIGN(const double ssim, StructuralSimilarity(image, noisy));
    ASSERT_OK_AND_ASSIGN(const double psnr, PeakSignalToNoise(image, noisy));
    EXPECT_NEAR(StructuralSimilarity(noisy, image).value(), ssim, 1e-9);
    EXPECT_EQ(PeakSignalToNoise(noisy, image).value(), psnr);
    EXPECT_LT(ssim, last_ssim);
    EXPECT_LT(psnr, last_psnr);
    EXPECT_GT(ssim, -1.0);
    last_ssim = ssim;
    last_psnr = psnr;
  }
}

TEST_P(SimilaritySeeds, PsnrIsThatOfTheMeanSquaredDifference) {
  std::mt19937 random(GetParam() + 100);
  const GreyFrame a = RandomGrey(random, 17, 11);
  const GreyFrame b = RandomGrey(random, 17, 11);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::pow(static_cast<double>(a.pixels[i]) - b.pixels[i], 2);
  const double expected = 10.0 * std::log10(255.0 * 255.0 / (sum / static_cast<double>(a.pixels.size())));
  EXPECT_NEAR(PeakSignalToNoise(a, b).value(), expected, 1e-9);
}

TEST_P(SimilaritySeeds, TheChoiceIsByTheMeanOverConsecutivePairs) {
  std::mt19937 random(GetParam() + 200);
  std::uniform_real_distribution<float> metres(0.0F, 12.0F);
  std::vector<DepthFrame> frames;
  for (int i = 0; i < 7; ++i) {
    DepthFrame frame{32, 24, {}};
    for (int k = 0; k < 32 * 24; ++k) frame.metres.push_back(metres(random));
    frames.push_back(frame);
  }
  for (const SimilarityMeasure measure : {SimilarityMeasure::kSsim, SimilarityMeasure::kPsnr}) {
    SimilarityCriterion criterion{.measure = measure, .threshold = 0.0, .frames = 5, .max_depth = 10.0};
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const GreyFrame a = BrightnessOf(frames[i], 10.0);
      const GreyFrame b = BrightnessOf(frames[i + 1], 10.0);
      sum += (measure == SimilarityMeasure::kSsim ? StructuralSimilarity(a, b) : PeakSignalToNoise(a, b)).value();
    }
    ASSERT_OK_AND_ASSIGN(SimilarityChoice choice, ChooseBySimilarity(frames, criterion));
    EXPECT_EQ(choice.pairs, 4) << "the first five frames";
    EXPECT_NEAR(choice.mean, sum / 4.0, 1e-9);
    criterion.threshold = choice.mean;
    EXPECT_EQ(ChooseBySimilarity(frames, criterion)->environment, Environment::kIndoor) << "not below the threshold";
    criterion.threshold = choice.mean + 1e-9;
    EXPECT_EQ(ChooseBySimilarity(frames, criterion)->environment, Environment::kOutdoor);
    criterion.frames = 100;
    EXPECT_EQ(ChooseBySimilarity(frames, criterion)->pairs, 6) << "all of them";
  }
}

TEST(BrightnessTable, CoversTheRangeOfDepths) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const DepthFrame depth{8, 1, {0.0F, -1.0F, NAN, kInf, 2.5F, 5.0F, 10.0F, 99.0F}};
  const GreyFrame grey = BrightnessOf(depth, 10.0);
  EXPECT_THAT(grey.pixels, ::testing::ElementsAre(0, 0, 0, 0, 64, 128, 255, 255));
  EXPECT_EQ(grey.width, 8);
}

TEST(SimilarityCriterionTable, RefusesInvalidValues) {
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_OK(Validate(SimilarityCriterion{}));
  EXPECT_STATUS(Validate(SimilarityCriterion{.threshold = NAN}), kBad, HasSubstr("threshold nan"));
  EXPECT_STATUS(Validate(SimilarityCriterion{.frames = 1}), kBad, HasSubstr("1 frames"));
  EXPECT_STATUS(Validate(SimilarityCriterion{.max_depth = 0.0}), kBad, HasSubstr("0 m"));
  const std::vector<DepthFrame> sizes = {{2, 1, {1, 1}}, {1, 2, {1, 1}}};
  EXPECT_STATUS(ChooseBySimilarity(sizes), kBad, HasSubstr("2x1 and 1x2"));
  const std::vector<DepthFrame> malformed = {{2, 1, {1, 1}}, {2, 1, {1}}};
  EXPECT_STATUS(ChooseBySimilarity(malformed), kBad, HasSubstr("1 samples"));
}

}  // namespace
}  // namespace enfilade::perception
