// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/png_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <string_view>

#include "tests/support/status_assertions.h"

namespace enfilade::grid {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

PixelImage RandomImage(int width, int height, int channels) {
  PixelImage image{.width = width, .height = height, .channels = channels, .samples = {}};
  std::mt19937 rng(11);
  for (int i = 0; i < width * height * channels; ++i) image.samples.push_back(static_cast<std::uint8_t>(rng()));
  return image;
}

// Bytes of a hand-made file, from hexadecimal.
std::string FromHex(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
  }
  return bytes;
}

class EveryChannelCount : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(PngCodec, EveryChannelCount, ::testing::Values(1, 2, 3, 4));

TEST_P(EveryChannelCount, IsRestoredUnchanged) {
  const PixelImage image = RandomImage(37, 11, GetParam());
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodePng(image));
  ASSERT_OK_AND_ASSIGN(const PixelImage decoded, DecodePng(png));
  EXPECT_EQ(decoded, image);
  ASSERT_OK_AND_ASSIGN(const std::string again, EncodePng(image));
  EXPECT_EQ(again, png);
}

TEST(PngCodec, WritesRowsBottomUp) {
  const PixelImage image{.width = 2, .height = 3, .channels = 1, .samples = {1, 2, 3, 4, 5, 6}};
  ASSERT_OK_AND_ASSIGN(
      const std::string png,
      EncodePng(PixelRows{.width = 2, .height = 3, .channels = 1, .top_row = image.samples.data() + 4, .stride = -2}));
  ASSERT_OK_AND_ASSIGN(const PixelImage decoded, DecodePng(png));
  EXPECT_THAT(decoded.samples, ElementsAre(5, 6, 3, 4, 1, 2));
}

// Made with zlib by hand, chunk by chunk.
constexpr std::string_view kOneBit =  // 8 x 1, 1-bit grey: 10110001
    "89504e470d0a1a0a0000000d4948445200000008000000010100000000cb7bd2ee0000000a4944415478da63d8080000b300b28c1a2b47"
    "0000000049454e44ae426082";
constexpr std::string_view kPalette =  // 2 x 1: (10, 20, 30) opaque, (200, 210, 220) with alpha 7
    "89504e470d0a1a0a0000000d4948445200000002000000010803000000c3fc8fb800000006504c54450a141ec8d2dc828d75dd00000002"
    "74524e53ff077bd3a5e90000000b49444154789c636060040000040002bf7a3f4a0000000049454e44ae426082";
constexpr std::string_view kInterlaced =  // 3 x 3 grey, 1 to 9, Adam7
    "89504e470d0a1a0a0000000d49484452000000030000000308000000010444daf5000000174944415478da636064606660e7646062e060"
    "6061650300012a002ea6a846fc0000000049454e44ae426082";
constexpr std::string_view kSixteenBit =
    "89504e470d0a1a0a0000000d49484452000000010000000110000000006aee47160000000b49444154789c636064020000070004764"
    "9e3280000000049454e44ae426082";
constexpr std::string_view kHuge =  // 100,000 x 100,000 grey; the data end at once
    "89504e470d0a1a0a0000000d49484452000186a0000186a008000000008d3954140000000b49444154789c6360800100000a00017f8074"
    "5e";

constexpr std::string_view kLarge =  // 16,384 x 16,384 RGB + alpha, interlaced; the data end at once
    "89504e470d0a1a0a0000000d4948445200004000000040000806000001decf20120000000b49444154789c6360800100000a00017f"
    "80745e";

TEST(PngCodec, ExpandsFewerBits) {
  ASSERT_OK_AND_ASSIGN(const PixelImage image, DecodePng(FromHex(kOneBit)));
  EXPECT_EQ(image.channels, 1);
  EXPECT_THAT(image.samples, ElementsAre(255, 0, 255, 255, 0, 0, 0, 255));
}

TEST(PngCodec, ExpandsPalettesWithTransparency) {
  ASSERT_OK_AND_ASSIGN(const PixelImage image, DecodePng(FromHex(kPalette)));
  EXPECT_EQ(image.channels, 4);
  EXPECT_THAT(image.samples, ElementsAre(10, 20, 30, 255, 200, 210, 220, 7));
}

TEST(PngCodec, ReadsInterlacedImages) {
  ASSERT_OK_AND_ASSIGN(const PixelImage image, DecodePng(FromHex(kInterlaced)));
  EXPECT_THAT(image.samples, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
}

TEST(PngCodec, RefusesSixteenBits) {
  EXPECT_STATUS(DecodePng(FromHex(kSixteenBit)), absl::StatusCode::kInvalidArgument, HasSubstr("16-bit"));
}

TEST(PngCodec, KeepsOrScalesSixteenBits) {
  ASSERT_OK_AND_ASSIGN(const PixelImage kept, DecodePng(FromHex(kSixteenBit), SixteenBits::kKept));
  EXPECT_THAT(kept.samples, ElementsAre(1, 2));
  ASSERT_OK_AND_ASSIGN(const PixelImage scaled, DecodePng(FromHex(kSixteenBit), SixteenBits::kScaled));
  EXPECT_THAT(scaled.samples, ElementsAre(1));  // 258 / 257
  EXPECT_STATUS(DecodePng(FromHex(kOneBit), SixteenBits::kKept), absl::StatusCode::kInvalidArgument,
                HasSubstr("do not have 16 bits"));
}

TEST(PngCodec, RefusesHugeImagesBeforeAllocating) {
  EXPECT_STATUS(DecodePng(FromHex(kHuge)), absl::StatusCode::kInvalidArgument, HasSubstr("too large"));
}

TEST(PngCodec, RefusesOtherFormats) {
  EXPECT_STATUS(DecodePng(""), absl::StatusCode::kInvalidArgument, HasSubstr("signature"));
  EXPECT_STATUS(DecodePng("P5\n1 1\n255\nx"), absl::StatusCode::kInvalidArgument, HasSubstr("signature"));
}

TEST(PngCodec, RefusesEveryTruncation) {
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodePng(RandomImage(9, 5, 3)));
  for (std::size_t size = 0; size < png.size() - 1; ++size) {
    EXPECT_FALSE(DecodePng(std::string_view(png).substr(0, size)).ok()) << size;
  }
}

TEST(PngCodec, RefusesEveryFlippedByteOrReadsOn) {
  // Each chunk has a checksum: a flipped byte is found, or lies where it does not matter (a chunk's name that becomes
  // another ancillary one). Neither may end the program.
  ASSERT_OK_AND_ASSIGN(const std::string png, EncodePng(RandomImage(9, 5, 1)));
  int refused = 0;
  for (std::size_t i = 0; i < png.size(); ++i) {
    std::string damaged = png;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    if (!DecodePng(damaged).ok()) ++refused;
  }
  EXPECT_GT(refused, static_cast<int>(png.size()) - 10);
}

TEST(PngCodec, RefusesLargeImagesInSmallFilesBeforeAllocating) {
  // 16,384 x 16,384 pixels are allowed, but not in 56 bytes.
  EXPECT_STATUS(DecodePng(FromHex(kLarge)), absl::StatusCode::kInvalidArgument, HasSubstr("too short"));
}

TEST(PngCodec, RefusesToWriteAnEmptyImage) {
  EXPECT_STATUS(EncodePng(PixelImage{}), absl::StatusCode::kInvalidArgument, HasSubstr("0 x 0"));
}

}  // namespace
}  // namespace enfilade::grid
