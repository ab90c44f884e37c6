// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/pictured_rooms.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/grid/files/rgb_image.h"
#include "io/file.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;

constexpr grid::Rgb kRed{255, 0, 0};
constexpr grid::Rgb kGreen{0, 255, 0};
constexpr grid::Rgb kBlue{0, 0, 255};

// Three rooms of 5 m by 4 m in a row, of 10 pixels a metre, parted by black walls of 0.2 m, with a speck of a fourth
// colour in the last one. The map's origin is 1 m right of and 2 m above the picture's lower left corner.
class PicturedRoomsTest : public ::testing::Test {
 protected:
  PicturedRoomsTest() {
    grid::RgbImage image(154, 40, {0, 0, 0});
    Fill(image, 0, 50, kRed);
    Fill(image, 52, 102, kGreen);
    Fill(image, 104, 154, kBlue);
    Fill(image, 130, 131, {9, 9, 9});
    rooms_.picture = directory_.path() / "rooms.png";
    const auto png = EncodePng(image);
    EXPECT_OK(png);
    EXPECT_OK(io::WriteFile(rooms_.picture, *png));
    rooms_.T_map_picture = {-1.0, -2.0, 0.0};
    rooms_.resolution = 0.1;
  }

  static void Fill(grid::RgbImage& image, int begin, int end, const grid::Rgb& colour) {
    for (int row = 0; row < image.height; ++row) {
      for (int column = begin; column < end; ++column) {
        std::copy(colour.begin(), colour.end(), image.samples.begin() + 3 * (row * image.width + column));
      }
    }
  }

  // A pose every 0.1 m and 0.2 s along x.
  DriveTruth Drive(const std::vector<double>& ends) {
    std::vector<TimedPose> trajectory;
    double x = ends.front();
    for (const double end : ends) {
      const int steps = std::max(1, static_cast<int>(std::lround(std::abs(end - x) / 0.1)));
      const double begin = x;
      for (int i = 1; i <= steps; ++i) {
        x = begin + (end - begin) * i / steps;
        trajectory.push_back({0.2 * static_cast<double>(trajectory.size()), {x, 0.0, 0.0}});
      }
    }
    return RoomsEntered("robot", trajectory, rooms_);
  }

  static std::vector<std::string> RoomsOf(const DriveTruth& truth) {
    std::vector<std::string> rooms{truth.poses.front().area};
    for (const TruePoint& point : truth.poses) {
      if (point.area != rooms.back()) rooms.push_back(point.area);
    }
    return rooms;
  }

  TemporaryDirectory directory_;
  PicturedRooms rooms_;
};

TEST_F(PicturedRoomsTest, FollowsTheColoursUnderTheRobot) {
  const DriveTruth truth = Drive({0.0, 13.0, 6.0});
  EXPECT_THAT(RoomsOf(truth), ElementsAre("#ff0000", "#00ff00", "#0000ff", "#00ff00"));
  ASSERT_EQ(truth.passages.size(), 3U);
  EXPECT_EQ(truth.passages[1].from, "#00ff00");
  EXPECT_EQ(truth.passages[1].to, "#0000ff");
  EXPECT_NEAR(truth.passages[1].T_campus_robot.x, 9.4, 0.11);
  EXPECT_EQ(truth.passages[1].door, truth.passages[2].door);
}

TEST_F(PicturedRoomsTest, KeepsTheRoomAcrossATouchOfAnotherAndASpeck) {
  EXPECT_THAT(RoomsOf(Drive({0.0, 4.3, 0.0})), ElementsAre("#ff0000"));
  EXPECT_THAT(RoomsOf(Drive({10.0, 14.0})), ElementsAre("#0000ff"));
}

TEST_F(PicturedRoomsTest, TurnsWithThePicture) {
  rooms_.T_map_picture = {2.0, -1.0, M_PI_2};  // the rooms lie along y
  EXPECT_THAT(RoomsOf(Drive({0.0, 1.5})), ElementsAre("#ff0000"));
}

TEST_F(PicturedRoomsTest, NamesAPictureThatCannotBeRead) {
  rooms_.picture = directory_.path() / "none.png";
  EXPECT_THROW(Drive({0.0, 1.0}), std::runtime_error);
}

}  // namespace
}  // namespace enfilade::testing
