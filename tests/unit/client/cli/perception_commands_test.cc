// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "client/cli/commands/commands.h"
#include "core/grid/files/png_codec.h"
#include "perception/cloud/decode_cloud.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/cli/command_test.h"
#include "tests/unit/perception/cloud/rooms.h"

namespace enfilade::cli {
namespace {

using perception::testing::PoseOf;
using perception::testing::Room;
using ::testing::HasSubstr;

// Squares of random grey: `shift` pixels of the picture are cut off at its left.
grid::PixelImage Squares(std::uint32_t seed, int shift) {
  std::mt19937 rng(seed);
  constexpr int kWide = 480;
  constexpr int kHigh = 320;
  std::vector<std::uint8_t> whole(kWide * kHigh, 128);
  for (int square = 0; square < 250; ++square) {
    const int side = 6 + static_cast<int>(rng() % 30);
    const int left = static_cast<int>(rng() % (kWide - 40));
    const int top = static_cast<int>(rng() % (kHigh - 40));
    const auto grey = static_cast<std::uint8_t>(rng() % 256);
    for (int row = top; row < top + side; ++row) {
      std::fill_n(whole.begin() + row * kWide + left, side, grey);
    }
  }
  grid::PixelImage image{.width = 440, .height = kHigh, .channels = 1, .samples = {}};
  for (int row = 0; row < kHigh; ++row) {
    const auto first = whole.begin() + row * kWide + shift;
    image.samples.insert(image.samples.end(), first, first + 440);
  }
  return image;
}

class PerceptionCommandsTest : public CommandTest {
 protected:
  std::string ImageFile(const std::string& name, std::uint32_t seed, int shift) const {
    return File(name, grid::EncodePng(Squares(seed, shift)).value());
  }

  // What is printed goes to `document_`.
  absl::Status Run(std::vector<std::string> arguments) {
    const auto add = [](CLI::App& app, const Globals& globals) {
      AddMatch(app, globals);
      AddEnvironment(app, globals);
    };
    const absl::Status status = RunCommandLine(add, std::move(arguments), true);
    document_ = printed_.empty() ? nlohmann::json() : nlohmann::json::parse(printed_);
    return status;
  }

  nlohmann::json document_;
};

TEST_F(PerceptionCommandsTest, JudgesImagesAndDrawsTheirMatches) {
  const std::string a = ImageFile("a.png", 1, 0);
  const std::string picture = directory_.path() / "matches.png";
  ASSERT_OK(Run({"match", "images", a, ImageFile("b.png", 1, 30), "-o", picture}));
  EXPECT_EQ(document_["accepted"], true);
  EXPECT_GT(document_["inliers"], 15);
  EXPECT_GE(document_["matches"], document_["inliers"]);
  ASSERT_OK_AND_ASSIGN(const grid::PixelImage drawn, grid::DecodePng(Content(picture)));
  EXPECT_EQ(drawn.width, 440 + 8 + 440);
  ASSERT_OK(Run({"match", "images", a, ImageFile("c.png", 2, 0)}));
  EXPECT_EQ(document_["accepted"], false);
}

TEST_F(PerceptionCommandsTest, NamesAnImageThatCannotBeRead) {
  const std::string a = ImageFile("a.png", 1, 0);
  EXPECT_STATUS(Run({"match", "images", a, "/nowhere/b.png"}), absl::StatusCode::kNotFound, HasSubstr("b.png"));
  EXPECT_STATUS(Run({"match", "images", File("text.jpg", "no image"), a}), absl::StatusCode::kInvalidArgument,
                HasSubstr("text.jpg: the image is neither"));
  EXPECT_STATUS(Run({"match", "images", File("empty.png", ""), a}), absl::StatusCode::kInvalidArgument,
                HasSubstr("0 bytes"));
}

TEST_F(PerceptionCommandsTest, RegistersCloudsFromAGuess) {
  const Eigen::Isometry3d truth = PoseOf(1.5, -0.5, 2.0, 0.1);
  const std::string target = File("target.pcd", perception::testing::EncodePcd(Room(3, 1)));
  const std::string source =
      File("source.pcd", perception::testing::EncodePcd(perception::Transformed(Room(3, 2), truth.inverse())));
  ASSERT_OK(Run({"match", "clouds", source, target, "--guess", "1.2", "-0.2", "0", "1.8"}));
  EXPECT_EQ(document_["accepted"], true);
  EXPECT_GT(document_["inlier_share"], 0.9);
  EXPECT_LT(document_["fitness"], 0.05);
  ASSERT_EQ(document_["T_target_source"].size(), 16U);
  for (int i = 0; i < 16; ++i) {
    EXPECT_NEAR(document_["T_target_source"][static_cast<std::size_t>(i)].get<double>(), truth.matrix()(i / 4, i % 4),
                0.03);
  }
  EXPECT_STATUS(Run({"match", "clouds", source, File("bad.pcd", "x")}), absl::StatusCode::kInvalidArgument,
                HasSubstr("bad.pcd: the cloud is neither PCD nor PLY"));
}

TEST_F(PerceptionCommandsTest, ChoosesTheEnvironmentOfALog) {
  ASSERT_OK(Run({"environment", enfilade::testing::ProjectData("logs/small.clf")}));
  EXPECT_EQ(document_["criterion"], "range");
  EXPECT_EQ(document_["environment"], "indoor");
  EXPECT_GT(document_["scans_judged"], 0);
}

TEST_F(PerceptionCommandsTest, SaysWhatACriterionLacks) {
  const std::string photograph = ImageFile("a.png", 1, 0);
  EXPECT_STATUS(Run({"environment", photograph, "--criterion", "scene"}), absl::StatusCode::kNotFound,
                HasSubstr("model"));
  EXPECT_STATUS(Run({"environment", photograph, "--criterion", "range"}), absl::StatusCode::kInvalidArgument,
                HasSubstr("no scans"));
  EXPECT_STATUS(Run({"environment", photograph}), absl::StatusCode::kInvalidArgument, HasSubstr("at least 2"));
}

}  // namespace
}  // namespace enfilade::cli
