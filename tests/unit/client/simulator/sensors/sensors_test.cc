// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/sensors/sensors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "client/simulator/campus/campus_yaml.h"
#include "core/grid/files/png_codec.h"
#include "fmt/format.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

std::unique_ptr<const World> WorldOf(const char* yaml) {
  absl::StatusOr<Campus> campus = ParseCampus(yaml);
  EXPECT_OK(campus.status());
  return std::make_unique<const World>(*std::move(campus));
}

// A room of 4 m x 6 m (inside) with a door in the north and a box in the south.
constexpr const char* kRoom = R"(
wall_thickness: 0.2
areas:
  - {id: a, rect: [-2.1, -3.1, 4.2, 6.2], height: 3, doors: [{id: d, side: north, at: 2.1, width: 1.0}]}
boxes:
  - {rect: [-0.5, -2.0, 1, 0.5], height: 0.5}
)";

ScannerOptions Exact() {
  ScannerOptions options;
  options.beams = 4;
  options.range_sigma = options.dropout = 0.0;
  options.T_robot_laser = {};
  options.height = 0.6;
  return options;
}

TEST(ReadScan, MeasuresWallsExactly) {
  const auto world = WorldOf(kRoom);
  const Viewpoint view{*world, "ground", {0.5, 1.0, M_PI / 2.0}};
  // A full turn from behind: south, east, north, west.
  sensor::LaserScan scan = ReadScan(view, Exact(), Noise(1));
  ASSERT_EQ(scan.ranges.size(), 4U);
  EXPECT_NEAR(scan.ranges[0], 4.0, 1e-6) << "over the low box";
  EXPECT_NEAR(scan.ranges[1], 1.5, 1e-6);
  EXPECT_NEAR(scan.ranges[3], 2.5, 1e-6);
  ScannerOptions low = Exact();
  low.height = 0.4;
  EXPECT_NEAR(ReadScan({*world, "ground", {0.0, 1.0, M_PI / 2.0}}, low, Noise(1)).ranges[0], 2.5, 1e-6);
  EXPECT_TRUE(std::isinf(ReadScan({*world, "ground", {0.0, 1.0, M_PI / 2.0}}, Exact(), Noise(1)).ranges[2]))
      << "out of the door";
}

TEST(ReadScan, DropsBeamsAndAddsNoise) {
  const auto world = WorldOf(kRoom);
  ScannerOptions options;
  options.dropout = 0.1;
  options.range_sigma = 0.05;
  const sensor::LaserScan scan = ReadScan({*world, "ground", {}}, options, Noise(3));
  const auto missing = std::count_if(scan.ranges.begin(), scan.ranges.end(), [](float r) { return std::isnan(r); });
  EXPECT_GT(missing, 40);
  EXPECT_LT(missing, 110);
  EXPECT_EQ(scan.ranges.size(), 720U);
  EXPECT_NEAR(scan.angle(719), M_PI - scan.angle_increment, 1e-9);
}

TEST(ReadScan, GlassAnswersNearItsNormalOnly) {
  const auto world = WorldOf(R"(
areas: [{id: a, rect: [0, 0, 10, 10], walls: false}]
walls: [{points: [[6, 0], [6, 10]], glass: true}, {points: [[9, 0], [9, 10]], thickness: 0}]
)");
  ScannerOptions options = Exact();
  options.beams = 720;
  const sensor::LaserScan scan = ReadScan({*world, "ground", {4.0, 5.0, 0.0}}, options, Noise(5));
  int glass = 0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double angle = std::abs(scan.angle(i));
    if (angle > 0.7 || std::isinf(scan.ranges[i])) continue;
    const double x = scan.ranges[i] * std::cos(angle);
    const bool pane = std::abs(x - 2.0) < 1e-3;
    EXPECT_TRUE(pane || std::abs(x - 5.0) < 1e-3);
    glass += pane ? 1 : 0;
    if (pane) {
      EXPECT_LT(angle, 0.45);
    }
  }
  EXPECT_GT(glass, 20);
}

TEST(ReadScan, PeopleStandInTheWay) {
  const auto world = WorldOf(R"(
areas: [{id: a, rect: [0, 0, 10, 10]}]
people: [{path: [[5, 2], [5, 8]], speed: 1.0, radius: 0.25}]
)");
  const auto ahead = [&](double seconds) {
    return ReadScan({*world, "ground", {2.0, 5.0, 0.0}, seconds}, Exact(), Noise(1)).ranges[2];
  };
  EXPECT_NEAR(ahead(3.0), 2.75, 1e-6);
  EXPECT_GT(ahead(0.0), 5.0);
  EXPECT_NEAR(ahead(9.0), 2.75, 1e-6) << "on the way back";
}

TEST(ReadCloud, HoldsFloorWallsAndCeiling) {
  const auto world = WorldOf(kRoom);
  CloudScannerOptions options;
  options.range_sigma = options.dropout = 0.0;
  const std::vector<float> cloud = ReadCloud({*world, "ground", {0.0, 0.0, 0.0}}, options, Noise(1));
  ASSERT_EQ(cloud.size() % 3, 0U);
  EXPECT_GT(cloud.size() / 3, 12000U);
  int floor = 0;
  for (std::size_t i = 0; i < cloud.size(); i += 3) {
    EXPECT_GT(cloud[i + 2], -1e-4);
    EXPECT_LT(cloud[i + 2], 3.0 + 1e-4);
    if (std::abs(cloud[i + 2]) < 1e-4) ++floor;
    if (cloud[i] > 1.9 && std::abs(cloud[i + 1]) < 2.9) {
      EXPECT_NEAR(cloud[i], 2.0, 1e-4);
    }
  }
  EXPECT_GT(floor, 0) << "through the door, and in the corner that is 4.1 m off or more";
}

TEST(ReadCamera, DepthIsTheDistanceAlongTheAxis) {
  const auto world = WorldOf(kRoom);
  CameraOptions options;
  options.width = 64;
  options.height = 48;
  options.depth_sigma = options.noise = 0.0;
  options.T_robot_camera = {};
  const CameraFrame frame = ReadCamera({*world, "ground", {0.0, 0.0, 0.0}}, options, Noise(1));
  for (int x = 20; x < 44; ++x) {
    EXPECT_NEAR(frame.depth[24 * 64 + static_cast<std::size_t>(x)], 2000, 1) << "a wall square to the axis";
  }
  ASSERT_OK_AND_ASSIGN(const std::string png, frame.GreyPng());
  ASSERT_OK_AND_ASSIGN(const grid::PixelImage image, grid::DecodePng(png));
  EXPECT_EQ(image.samples, frame.grey);
  ASSERT_OK_AND_ASSIGN(const std::string depth, frame.DepthPng());
  EXPECT_EQ(depth.substr(1, 3), "PNG");
  EXPECT_EQ(depth[24], 16) << "bits a sample";
}

TEST(ReadCamera, DoorsLookDifferentUnlessTexturesRepeat) {
  const auto difference = [](double period) {
    const std::string yaml = fmt::format(R"(
textures: {{t: {{period: {}}}}}
areas: [{{id: a, rect: [0, 0, 20, 6], texture: t, doors: [{{id: d1, side: north, at: 5}}, {{id: d2, side: north, at: 10}}]}}]
)",
                                         period);
    const auto world = WorldOf(yaml.c_str());
    CameraOptions options;
    options.noise = 0.0;
    options.width = 160;
    options.height = 120;
    options.field_of_view = 0.9;
    const CameraFrame one = ReadCamera({*world, "ground", {5.0, 3.0, M_PI / 2.0}}, options, Noise(1));
    const CameraFrame two = ReadCamera({*world, "ground", {10.0, 3.0, M_PI / 2.0}}, options, Noise(1));
    double sum = 0.0;
    for (std::size_t i = 0; i < one.grey.size(); ++i) sum += std::abs(one.grey[i] - two.grey[i]);
    return sum / static_cast<double>(one.grey.size());
  };
  EXPECT_GT(difference(0.0), 10.0);
  EXPECT_LT(difference(5.0), difference(0.0) / 8.0) << "but for the room's far ends";
}

}  // namespace
}  // namespace enfilade::simulator
