// SPDX-License-Identifier: Apache-2.0
// Files that are no plans, or unusual ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

#include "core/grid/files/png_codec.h"
#include "fmt/format.h"
#include "perception/plan/read_plan.h"
#include "tests/support/plans/drawn_plan.h"
#include "tests/support/plans/pdf_plan.h"

namespace enfilade::perception {
namespace {

using enfilade::testing::EncryptedPdfPlan;
using enfilade::testing::PdfPlan;
using ::testing::HasSubstr;

void ExpectRefused(const std::string& bytes, const std::string& message, const ReadPlanOptions& options = {}) {
  const auto plan = DecodePlan(bytes, options);
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kInvalidArgument) << plan.status();
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr(message));
}

std::string GreyPng(int width, int height, const std::vector<std::uint8_t>& pixels) {
  return grid::EncodePng(grid::PixelImage{.width = width, .height = height, .channels = 1, .samples = pixels}).value();
}

grid::PixelImage Drawn() { return grid::DecodePng(enfilade::testing::DrawPlan().png).value(); }

std::string Encoded(const cv::Mat& image, const char* extension) {
  std::vector<uchar> bytes;
  cv::imencode(extension, image, bytes);
  return {bytes.begin(), bytes.end()};
}

cv::Mat DrawnMat() {
  const grid::PixelImage drawn = Drawn();
  return cv::Mat(drawn.height, drawn.width, CV_8U, const_cast<std::uint8_t*>(drawn.samples.data())).clone();
}

TEST(BadPlans, TruncatedPicturesAreRefused) {
  const std::string png = enfilade::testing::DrawPlan().png;
  ExpectRefused(png.substr(0, png.size() / 2), "ends within the image");
  const std::string jpeg = Encoded(DrawnMat(), ".jpg");
  ExpectRefused(jpeg.substr(0, jpeg.size() / 2), "truncated");
}

TEST(BadPlans, HugePicturesAreRefusedBeforeTheyAreDecoded) {
  std::string png = enfilade::testing::DrawPlan().png;
  for (const std::size_t at : {16, 20}) png.replace(at, 4, std::string("\0\0\x4E\x20", 4));  // 20,000
  ExpectRefused(png, "20000x20000");
}

TEST(BadPlans, ABlankPageATextAndAPhotoAreRefusedWithTheCount) {
  ExpectRefused(GreyPng(400, 300, std::vector<std::uint8_t>(120'000, 255)), "0 walls, 8 needed");
  std::vector<std::uint8_t> text(800 * 600, 255);
  for (int row = 0; row < 25; ++row) {
    for (int letter = 0; letter < 60; ++letter) {
      for (int k = 0; k < 9; ++k) {  // an upright and a bar, which differ from letter to letter
        text[(30 + row * 22 + k) * 800 + 40 + letter * 12] = 0;
        text[(30 + row * 22 + (letter * 5 + row) % 9) * 800 + 40 + letter * 12 + k / 2] = 0;
      }
    }
  }
  ExpectRefused(GreyPng(800, 600, text), "0 walls, 8 needed");
  std::vector<std::uint8_t> photo;  // rough plaster under a lamp
  std::mt19937 random(3);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      photo.push_back(static_cast<std::uint8_t>(150 + 60 * std::sin(x / 200.0) * std::cos(y / 150.0) + random() % 12));
    }
  }
  ExpectRefused(GreyPng(640, 480, photo), "walls, 8 needed");
}

TEST(UnusualPlans, DeepAndTransparentPicturesAreReadLikeOthers) {
  const std::size_t walls = DecodePlan(enfilade::testing::DrawPlan().png)->graph.walls.size();
  cv::Mat deep;
  DrawnMat().convertTo(deep, CV_16U, 257);
  const auto from_deep = DecodePlan(Encoded(deep, ".png"));
  ASSERT_TRUE(from_deep.ok()) << from_deep.status();
  EXPECT_EQ(from_deep->graph.walls.size(), walls);
  for (const int ink : {0, 255}) {  // the drawing is in the transparency alone
    const grid::PixelImage drawn = Drawn();
    grid::PixelImage image{.width = drawn.width, .height = drawn.height, .channels = 4, .samples = {}};
    for (const std::uint8_t sample : drawn.samples) {
      for (int k = 0; k < 3; ++k) image.samples.push_back(static_cast<std::uint8_t>(ink));
      image.samples.push_back(static_cast<std::uint8_t>(255 - sample));
    }
    const auto plan = DecodePlan(grid::EncodePng(image).value());
    ASSERT_TRUE(plan.ok()) << plan.status();
    EXPECT_NEAR(static_cast<double>(plan->graph.walls.size()), static_cast<double>(walls), 3);
  }
}

TEST(UnusualPlans, CmykIsReadLikeOthers) {
  const cv::Mat drawn = DrawnMat();
  std::vector<std::uint8_t> inks;  // inverted, as Adobe stores them: black alone
  for (int y = 0; y < drawn.rows; ++y) {
    for (int x = 0; x < drawn.cols; ++x) inks.insert(inks.end(), {255, 255, 255, drawn.at<std::uint8_t>(y, x)});
  }
  const tjhandle encoder = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  ASSERT_EQ(tjCompress2(encoder, inks.data(), drawn.cols, 0, drawn.rows, TJPF_CMYK, &bytes, &size, TJSAMP_444, 95, 0),
            0);
  const std::string jpeg(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  tjDestroy(encoder);
  const auto plan = DecodePlan(jpeg);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_NEAR(static_cast<double>(plan->graph.walls.size()),
              static_cast<double>(DecodePlan(enfilade::testing::DrawPlan().png)->graph.walls.size()), 3);
}

TEST(UnusualPlans, JpegIsTurnedAsItSays) {
  std::string jpeg = Encoded(DrawnMat(), ".jpg");
  const auto upright = DecodePlan(jpeg);
  ASSERT_TRUE(upright.ok()) << upright.status();
  const std::string exif(
      "\xFF\xE1\x00\x22"
      "Exif\0\0MM\0\x2A\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0",
      36);  // orientation 6: turn clockwise
  jpeg.insert(2, exif);
  const auto turned = DecodePlan(jpeg);
  ASSERT_TRUE(turned.ok()) << turned.status();
  EXPECT_EQ(turned->picture->width, upright->picture->height);
  EXPECT_EQ(turned->picture->height, upright->picture->width);
}

TEST(PdfPlans, APageIsReadAsAPicture) {
  const auto plan = DecodePlan(PdfPlan(1));
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->graph.walls.size(), 40u) << "a grid of 4 x 4 rooms";
  EXPECT_EQ(plan->graph.rooms.size(), 16u);
  EXPECT_EQ(DecodePlan(PdfPlan(2), {.page = 2})->graph.walls.size(), 40u);
}

TEST(PdfPlans, ManyPagesNeedAChoiceAndEncryptedOnesAreRefused) {
  ExpectRefused(PdfPlan(300), "300 pages: choose one (page)");
  ExpectRefused(PdfPlan(2), "page 3: the PDF has 2", {.page = 3});
  ExpectRefused(EncryptedPdfPlan(), "encrypted");
  ExpectRefused("%PDF-1.4\nnothing", "PDF");
}

TEST(BuildingPlans, NameWhatIsMissing) {
  const std::string vertices = "vertices: [[0, 0, 0, \"\"], [90, 0, 0, \"\"]]";
  ExpectRefused("levels: {L1: {" + vertices + ", walls: [[0, 1, {}]]}}", "no measured line");
  ExpectRefused("levels: {L1: {" + vertices + ", measurements: [[0, 1, {distance: [3, 9]}]], walls: [[0, 7, {}]]}}",
                "a vertex that does not exist");
  ExpectRefused("levels: {L1: {" + vertices + ", measurements: [[0, 1, {distance: [3, 9]}]], walls: [[0, 1, {}]]}}",
                "no level \"L9\"; it has L1", {.level = "L9"});
}

std::string SvgOf(const std::string& body) { return R"(<svg xmlns="http://www.w3.org/2000/svg">)" + body + "</svg>"; }

void ExpectTooMuch(const std::string& bytes, const std::string& message) {
  const auto plan = DecodePlan(bytes);
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kResourceExhausted) << plan.status();
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr(message));
}

TEST(VectorPlans, ThatWouldHaveMoreThanAMillionWallsAreRefused) {
  std::string crossing;  // 1,001 lines across 1,001 others
  for (int i = 0; i <= 1000; ++i) crossing += fmt::format("M{0} -1V1001M-1 {0}H1001", i);
  ExpectTooMuch(SvgOf("<path d=\"" + crossing + "\"/>"), "cross so often");
}

TEST(VectorPlans, WhoseLinesLieOnOneSpotAreRefused) {
  std::string spot = "M0 0H100V100H0Z";
  std::mt19937 random(7);
  for (int i = 0; i < 40'000; ++i) spot += fmt::format("M{} 50l{} 1e-3", 50 + 1e-7 * (random() % 1000), 1e-3);
  ExpectTooMuch(SvgOf("<path d=\"" + spot + "\"/>"), "lie within");
}

// With a look at all pairs of its walls this would take an hour.
TEST(VectorPlans, OfACampusAreRead) {
  constexpr int kRooms = 150;  // in each of as many rows
  std::string walls;
  for (int row = 0; row < kRooms; ++row) {
    walls += fmt::format("M0 {}H{}", 40 * row, 40 * kRooms);
    for (int room = 0; room <= kRooms; ++room) walls += fmt::format("M{} {}v30", 40 * room, 40 * row);
  }
  const auto plan = DecodePlan(SvgOf("<path d=\"" + walls + "\"/>"),
                               {.measure = PlanMeasure{.from = {0, 0}, .to = {40, 0}, .metres = 4}});
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->graph.walls.size(), 2u * kRooms * kRooms + kRooms);
  EXPECT_EQ(plan->graph.doors.size(), (kRooms + 1u) * (kRooms - 1u));
}

TEST(VectorPlans, BecomePlanarWithDoorsAndRooms) {
  std::string svg = R"(<svg xmlns="http://www.w3.org/2000/svg">)";
  svg += R"(<rect x="0" y="0" width="400" height="200"/>)";
  for (const int x : {100, 200, 300}) {
    svg += fmt::format(R"(<path d="M{0} 0V80M{0} 110V200"/>)", x);
  }
  const auto plan = DecodePlan(svg + "</svg>", {.measure = PlanMeasure{.from = {0, 0}, .to = {400, 0}, .metres = 12}});
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->graph.walls.size(), 16u);
  EXPECT_EQ(plan->graph.doors.size(), 3u);
  EXPECT_EQ(plan->graph.rooms.size(), 4u);
  EXPECT_NEAR(*plan->graph.metres_per_unit, 0.03, 1e-12);
}

}  // namespace
}  // namespace enfilade::perception
