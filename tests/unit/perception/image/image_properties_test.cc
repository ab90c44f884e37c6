// SPDX-License-Identifier: Apache-2.0
// Headers, feature bytes, descriptor matching and geometric verification against plain implementations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "perception/image/descriptor_matching.h"
#include "perception/image/feature_codec.h"
#include "perception/image/geometric_verification.h"
#include "perception/image/image_header.h"
#include "perception/image/match_series.h"
#include "tests/support/status_assertions.h"

namespace enfilade::perception {
namespace {

using ::testing::HasSubstr;

FeatureSet RandomFeatures(std::mt19937& random, std::size_t sift, std::size_t akaze) {
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  FeatureSet set;
  set.width = 640;
  set.height = 480;
  const auto keypoint = [&] {
    return Keypoint{.x = 640.0F * unit(random),
                    .y = 480.0F * unit(random),
                    .size = 1.0F + 9.0F * unit(random),
                    .angle = 6.28F * unit(random)};
  };
  for (std::size_t i = 0; i < sift; ++i) set.sift.push_back(keypoint());
  for (std::size_t i = 0; i < akaze; ++i) set.akaze.push_back(keypoint());
  for (std::size_t i = 0; i < sift * kSiftBytes; ++i)
    set.sift_descriptors.push_back(static_cast<std::uint8_t>(random()));
  for (std::size_t i = 0; i < akaze * kAkazeBytes; ++i) {
    set.akaze_descriptors.push_back(static_cast<std::uint8_t>(random()));
  }
  return set;
}

class FeatureSeeds : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Features, FeatureSeeds, ::testing::Range(1U, 16U));

TEST_P(FeatureSeeds, RoundTripAsBytes) {
  std::mt19937 random(GetParam());
  const FeatureSet features = RandomFeatures(random, random() % 20, random() % 20);
  const std::string bytes = EncodeFeatures(features);
  ASSERT_OK_AND_ASSIGN(const FeatureSet decoded, DecodeFeatures(bytes));
  EXPECT_EQ(decoded, features);
  for (int trial = 0; trial < 300; ++trial) {
    std::string damaged = bytes;
    damaged[random() % damaged.size()] = static_cast<char>(random());
    if (random() % 4 == 0) damaged.resize(random() % damaged.size());
    const auto result = DecodeFeatures(damaged);
    if (!result.ok()) {
      EXPECT_CODE(result, absl::StatusCode::kDataLoss);
      continue;
    }
    EXPECT_EQ(result->sift_descriptors.size(), result->sift.size() * kSiftBytes);
    EXPECT_EQ(result->akaze_descriptors.size(), result->akaze.size() * kAkazeBytes);
    for (const Keypoint& keypoint : result->sift) EXPECT_TRUE(std::isfinite(keypoint.x) && keypoint.size > 0.0F);
  }
}

// Nearest neighbours by sorting all distances; `distance` as in the product, the ratio on the same scale.
template <typename Distance>
std::vector<DescriptorMatch> Exhaustive(std::size_t a, std::size_t b, double ratio, bool mutual,
                                        const Distance& distance) {
  std::vector<DescriptorMatch> matches;
  if (a < 2 || b < 2) return matches;
  const auto nearest = [](std::size_t count, const auto& to) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < count; ++i) best = to(i) < to(best) ? i : best;
    double second = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count; ++i) second = i == best ? second : std::min(second, to(i));
    return std::pair(best, second);
  };
  for (std::size_t i = 0; i < a; ++i) {
    const auto [j, second] = nearest(b, [&](std::size_t k) { return distance(i, k); });
    if (!(distance(i, j) < ratio * second)) continue;
    if (mutual && nearest(a, [&, j = j](std::size_t k) { return distance(k, j); }).first != i) continue;
    matches.push_back({static_cast<int>(i), static_cast<int>(j)});
  }
  return matches;
}

TEST_P(FeatureSeeds, MatchesAreThoseOfAnExhaustiveSearch) {
  std::mt19937 random(GetParam() + 100);
  const FeatureSet a = RandomFeatures(random, 25, 25);
  // Some of b's descriptors are a's with a few bits changed.
  FeatureSet b = RandomFeatures(random, 30, 20);
  for (std::size_t i = 0; i < 10; ++i) {
    std::copy_n(a.sift_descriptors.begin() + static_cast<std::ptrdiff_t>(2 * i * kSiftBytes), kSiftBytes,
                b.sift_descriptors.begin() + static_cast<std::ptrdiff_t>(3 * i * kSiftBytes));
    std::copy_n(a.akaze_descriptors.begin() + static_cast<std::ptrdiff_t>(2 * i * kAkazeBytes), kAkazeBytes,
                b.akaze_descriptors.begin() + static_cast<std::ptrdiff_t>((19 - i) * kAkazeBytes));
  }
  for (int changes = 0; changes < 200; ++changes) {
    b.sift_descriptors[random() % b.sift_descriptors.size()] ^= 8;
    b.akaze_descriptors[random() % b.akaze_descriptors.size()] ^= 2;
  }
  const auto sift = [&](std::size_t i, std::size_t j) {
    double sum = 0.0;
    for (std::size_t k = 0; k < kSiftBytes; ++k) {
      sum += std::pow(
          static_cast<double>(a.sift_descriptors[i * kSiftBytes + k]) - b.sift_descriptors[j * kSiftBytes + k], 2);
    }
    return std::sqrt(sum);
  };
  const auto akaze = [&](std::size_t i, std::size_t j) {
    int bits = 0;
    for (std::size_t k = 0; k < kAkazeBytes; ++k) {
      bits += std::popcount(
          static_cast<unsigned>(a.akaze_descriptors[i * kAkazeBytes + k] ^ b.akaze_descriptors[j * kAkazeBytes + k]));
    }
    return static_cast<double>(bits);
  };
  for (const bool mutual : {false, true}) {
    const RatioTest test{.sift = 0.8, .akaze = 0.75, .mutual = mutual};
    const auto by_sift = MatchSift(a, b, test);
    EXPECT_EQ(by_sift, Exhaustive(25, 30, 0.8, mutual, sift));
    EXPECT_GE(by_sift.size(), 10U);
    const auto by_akaze = MatchAkaze(a, b, test);
    EXPECT_EQ(by_akaze, Exhaustive(25, 20, 0.75, mutual, akaze));
    EXPECT_GE(by_akaze.size(), 10U);
  }
  EXPECT_TRUE(MatchSift(a, RandomFeatures(random, 1, 1), {}).empty()) << "no second nearest";
}

// Keypoints as a homography moves them, with their local change of size and direction.
TentativeMatch MovedBy(const Eigen::Matrix3d& H, const Eigen::Vector2d& p) {
  const auto map = [&](const Eigen::Vector2d& q) {
    const Eigen::Vector3d h = H * q.homogeneous();
    return Eigen::Vector2d(h.hnormalized());
  };
  const Eigen::Vector2d dx = (map(p + Eigen::Vector2d(0.01, 0)) - map(p)) / 0.01;
  const Eigen::Vector2d dy = (map(p + Eigen::Vector2d(0, 0.01)) - map(p)) / 0.01;
  const double determinant = dx.x() * dy.y() - dx.y() * dy.x();
  return {.a = p.cast<float>(),
          .b = map(p).cast<float>(),
          .octaves = static_cast<float>(0.5 * std::log2(determinant)),
          .rotation = static_cast<float>(std::atan2(dx.y() - dy.x(), dx.x() + dy.y()))};
}

TEST_P(FeatureSeeds, VerificationSeparatesAPlaneFromOutliers) {
  std::mt19937 random(GetParam() + 200);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const double angle = 0.4 * unit(random);
  const double scale = std::exp2(0.4 * unit(random));
  Eigen::Matrix3d H;
  H << scale * std::cos(angle), -scale * std::sin(angle), 40.0 * unit(random), scale * std::sin(angle),
      scale * std::cos(angle), 40.0 * unit(random), 1e-4 * unit(random), 1e-4 * unit(random), 1.0;
  std::vector<TentativeMatch> matches;
  for (int i = 0; i < 60; ++i) {
    TentativeMatch match = MovedBy(H, {320.0 + 300.0 * unit(random), 240.0 + 220.0 * unit(random)});
    if (i % 3 == 0) match.b += Eigen::Vector2f(60.0F + 100.0F * static_cast<float>(std::abs(unit(random))), -80.0F);
    matches.push_back(match);
  }
  ImageMatchOptions options;
  options.max_planes = 1;
  ASSERT_OK_AND_ASSIGN(const Verification verified, VerifyGeometry(matches, 3.0, options));
  ASSERT_EQ(verified.is_inlier.size(), matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) EXPECT_EQ(verified.is_inlier[i] != 0, i % 3 != 0) << i;
  ASSERT_TRUE(verified.H_b_a.has_value());
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(100, 100), Eigen::Vector2d(500, 300)}) {
    const Eigen::Vector2d expected = (H * p.homogeneous()).hnormalized();
    EXPECT_LT((Eigen::Vector2d((*verified.H_b_a * p.homogeneous()).hnormalized()) - expected).norm(), 1.0);
  }
  // Keypoints of another size or direction do not fit the plane, though their positions do.
  for (TentativeMatch& match : matches) match.rotation += 1.0F;
  ASSERT_OK_AND_ASSIGN(const Verification turned, VerifyGeometry(matches, 3.0, options));
  EXPECT_EQ(std::count(turned.is_inlier.begin(), turned.is_inlier.end(), 1), 0);
  options.model = GeometricModel::kNone;
  ASSERT_OK_AND_ASSIGN(const Verification all, VerifyGeometry(matches, 3.0, options));
  EXPECT_EQ(std::count(all.is_inlier.begin(), all.is_inlier.end(), 1), 60);
}

TEST(VerifyGeometryTest, TakesTooFewMatches) {
  for (const GeometricModel model : {GeometricModel::kPlanes, GeometricModel::kFundamental, GeometricModel::kNone}) {
    ImageMatchOptions options;
    options.model = model;
    for (std::size_t count = 0; count < 4; ++count) {
      ASSERT_OK_AND_ASSIGN(const Verification verified,
                           VerifyGeometry(std::vector<TentativeMatch>(count), 3.0, options));
      EXPECT_EQ(verified.is_inlier.size(), count);
    }
  }
}

std::string PngHeader(std::uint32_t width, std::uint32_t height, int depth, int color) {
  std::string bytes("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR", 16);
  for (const std::uint32_t value : {width, height}) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> static_cast<unsigned>(shift));
  }
  bytes += static_cast<char>(depth);
  bytes += static_cast<char>(color);
  return bytes + std::string(7, '\0');
}

TEST(ImageHeaderTable, ReadsEveryKindOfPng) {
  struct Row {
    int color;
    int components;
  };
  for (const Row& row : {Row{0, 1}, Row{2, 3}, Row{3, 3}, Row{4, 2}, Row{6, 4}}) {
    for (const int depth : {1, 8, 16}) {
      ASSERT_OK_AND_ASSIGN(const ImageHeader header, ReadImageHeader(PngHeader(4'000'000'000, 7, depth, row.color)));
      EXPECT_EQ(header.width, 4'000'000'000) << "not negative";
      EXPECT_EQ(header.height, 7);
      EXPECT_EQ(header.components, row.components);
      EXPECT_EQ(header.bit_depth, depth);
    }
  }
  EXPECT_STATUS(ReadImageHeader(PngHeader(1, 1, 8, 5)), absl::StatusCode::kInvalidArgument, HasSubstr("colour type 5"));
  const std::string whole = PngHeader(1, 1, 8, 0);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_CODE(ReadImageHeader(whole.substr(0, size)), absl::StatusCode::kInvalidArgument) << size;
  }
}

// SOI, an application segment, and a frame header of the kind `marker`.
std::string JpegHeader(unsigned char marker) {
  std::string bytes("\xff\xd8\xff\xe0\x00\x04xx", 8);
  bytes += '\xff';
  bytes += static_cast<char>(marker);
  return bytes + std::string("\x00\x11\x08\x01\x02\x03\x04\x03", 8) + std::string(9, '\x01');
}

TEST(ImageHeaderTable, ReadsEveryKindOfJpeg) {
  for (unsigned marker = 0xC0; marker <= 0xCF; ++marker) {
    const auto header = ReadImageHeader(JpegHeader(static_cast<unsigned char>(marker)));
    if (marker == 0xC4 || marker == 0xC8 || marker == 0xCC) {  // tables, not frames
      EXPECT_FALSE(header.ok()) << marker;
      continue;
    }
    ASSERT_OK(header);
    EXPECT_EQ(header->format, ImageFormat::kJpeg);
    EXPECT_EQ(header->height, 0x0102);
    EXPECT_EQ(header->width, 0x0304);
    EXPECT_EQ(header->components, 3);
    EXPECT_EQ(header->bit_depth, 8);
  }
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_STATUS(ReadImageHeader(std::string("\xff\xd8\xff\xe0\x00\x01", 6)), kBad, HasSubstr("impossible length 1"));
  EXPECT_STATUS(ReadImageHeader(std::string("\xff\xd8\xff\xda\x00\x02", 6)), kBad, HasSubstr("ends before"));
  EXPECT_STATUS(ReadImageHeader(std::string("\xff\xd8\xff\xe0\x00\x02zz\x00\x00", 10)), kBad, HasSubstr("no marker"));
}

TEST(FrameSizes, AreChecked) {
  EXPECT_OK(Validate(GreyFrame{2, 3, std::vector<std::uint8_t>(6)}));
  EXPECT_OK(Validate(ColorFrame{2, 3, std::vector<std::uint8_t>(18)}));
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_STATUS(Validate(GreyFrame{2, 3, std::vector<std::uint8_t>(5)}), kBad, HasSubstr("5 samples: expected 6"));
  EXPECT_STATUS(Validate(ColorFrame{2, 3, std::vector<std::uint8_t>(6)}), kBad, HasSubstr("expected 18"));
  EXPECT_STATUS(Validate(DepthFrame{0, 3, {}}), kBad, HasSubstr("0x3"));
  EXPECT_STATUS(Validate(DepthFrame{-2, -3, std::vector<float>(6)}), kBad, HasSubstr("-2x-3"));
}

}  // namespace
}  // namespace enfilade::perception
