// SPDX-License-Identifier: Apache-2.0
// Photos of plans that lie on a table.
#include "tests/support/plans/photo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "core/grid/files/png_codec.h"
#include "core/prior/formats/geojson_plan.h"
#include "fmt/format.h"
#include "perception/plan/read_plan.h"
#include "tests/support/plans/drawn_plan.h"
#include "tests/support/plans/plan_scores.h"

namespace enfilade::perception {
namespace {

using ::enfilade::testing::DrawnPlan;
using ::enfilade::testing::Photo;
using ::enfilade::testing::PhotoOptions;
using ::enfilade::testing::WallStyle;
using ::testing::HasSubstr;

struct PhotoCase {
  std::string name;
  WallStyle style = WallStyle::kFilled;
  PhotoOptions photo;
};

class PlanPhotoTest : public ::testing::TestWithParam<PhotoCase> {};

Eigen::Vector2d Moved(const Eigen::Matrix3d& H, const Eigen::Vector2d& p) {
  return (H * p.homogeneous()).eval().hnormalized();
}

TEST_P(PlanPhotoTest, IsReadLikeThePlanItself) {
  const DrawnPlan drawn =
      enfilade::testing::DrawPlan({.style = GetParam().style, .px_per_m = 50, .line_px = 3, .furniture = true});
  const Photo photo = enfilade::testing::TakePhoto(drawn.png, GetParam().photo);
  const auto flat = DecodePlan(drawn.png);
  ASSERT_TRUE(flat.ok()) << flat.status();
  ASSERT_FALSE(flat->graph.H_sheet_photo.has_value());
  const auto plan = DecodePlan(photo.png);
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_TRUE(plan->graph.H_sheet_photo.has_value());
  EXPECT_THAT(plan->warnings, ::testing::Contains(HasSubstr("photo")));
  const Eigen::Matrix3d H = *plan->graph.H_sheet_photo * photo.H_photo_sheet;
  const Eigen::Vector2d origin = Moved(H, {0, 0});
  const double wide = (Moved(H, Eigen::Vector2d(drawn.width, 0)) - origin).norm() / drawn.width;
  const double high = (Moved(H, Eigen::Vector2d(0, drawn.height)) - origin).norm() / drawn.height;
  EXPECT_NEAR(wide / high, 1, 0.03) << "the page's aspect ratio";
  prior::PlanGraph truth = drawn.truth;
  for (prior::PlanCorner& corner : truth.corners) corner.point = Moved(H, corner.point);
  for (prior::PlanDoor& door : truth.doors) door.from = Moved(H, door.from), door.to = Moved(H, door.to);
  const auto tolerance = enfilade::testing::InUnits({}, *drawn.truth.metres_per_unit / std::sqrt(wide * high));
  const auto flat_tolerance = enfilade::testing::InUnits({}, *drawn.truth.metres_per_unit);
  const auto walls = enfilade::testing::ScoreWalls(plan->graph, truth, tolerance);
  const auto flat_walls = enfilade::testing::ScoreWalls(flat->graph, drawn.truth, flat_tolerance);
  EXPECT_GE(walls.recall, flat_walls.recall - 0.03);
  EXPECT_GE(walls.precision, flat_walls.precision - 0.03);
  EXPECT_GE(enfilade::testing::ScoreCorners(plan->graph, truth, tolerance).recall, 0.9);
  EXPECT_GE(enfilade::testing::ScoreDoors(plan->graph, truth, tolerance).recall, 0.7);
}

std::vector<PhotoCase> PhotoCases() {
  std::vector<PhotoCase> cases;
  for (const WallStyle style : {WallStyle::kFilled, WallStyle::kDoubleLine}) {
    const std::string name = style == WallStyle::kFilled ? "Filled" : "Double";
    cases.push_back({name + "FromAbove", style, {.tilt_deg = 1, .roll_deg = 8}});
    cases.push_back({name + "FromTheFront", style, {.tilt_deg = 30, .seed = 2}});
    cases.push_back({name + "FromTheSide", style, {.tilt_deg = 15, .pan_deg = -25, .roll_deg = -12, .seed = 3}});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(All, PlanPhotoTest, ::testing::ValuesIn(PhotoCases()),
                         [](const auto& photo) { return photo.param.name; });

TEST(PlanPhoto, MeasuredPointsAreThoseOfThePhoto) {
  const DrawnPlan drawn = enfilade::testing::DrawPlan({.px_per_m = 50});
  const Photo photo = enfilade::testing::TakePhoto(drawn.png, {.tilt_deg = 25});
  const Eigen::Vector2d from = drawn.truth.corners[drawn.truth.walls[3].from].point;
  const Eigen::Vector2d to = drawn.truth.corners[drawn.truth.walls[3].to].point;
  const double metres = (to - from).norm() / 50;
  const auto plan = DecodePlan(photo.png, {.measure = PlanMeasure{.from = Moved(photo.H_photo_sheet, from),
                                                                  .to = Moved(photo.H_photo_sheet, to),
                                                                  .metres = metres}});
  ASSERT_TRUE(plan.ok()) << plan.status();
  const Eigen::Vector2d in_sheet = prior::ToSheet(plan->graph, Moved(photo.H_photo_sheet, to)) -
                                   prior::ToSheet(plan->graph, Moved(photo.H_photo_sheet, from));
  EXPECT_NEAR(*plan->graph.metres_per_unit * in_sheet.norm(), metres, 1e-9);
  // The homography is kept with the plan.
  const auto again = prior::ReadGeoJsonPlan(prior::WriteGeoJsonPlan(plan->graph));
  ASSERT_TRUE(again.ok()) << again.status();
  ASSERT_TRUE(again->H_sheet_photo.has_value());
  EXPECT_EQ(*again->H_sheet_photo, *plan->graph.H_sheet_photo);
}

std::string Png(int width, int height, const std::vector<std::uint8_t>& pixels) {
  return grid::EncodePng(grid::PixelImage{.width = width, .height = height, .channels = 1, .samples = pixels}).value();
}

TEST(PlanPhoto, DrawingsScansAndMapsAreNoPhotos) {
  for (const bool bright : {false, true}) {
    const auto drawing = DecodePlan(enfilade::testing::DrawPlan({.turn_deg = 5, .bright_lines = bright}).png);
    ASSERT_TRUE(drawing.ok()) << drawing.status();
    EXPECT_FALSE(drawing->graph.H_sheet_photo.has_value());
  }
  // A scan whose paper fills the picture, shaded towards an edge.
  const auto scan = DecodePlan(enfilade::testing::DrawPlan({.turn_deg = 3, .shade_at_edge = 0.4}).png);
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_FALSE(scan->graph.H_sheet_photo.has_value());
  // What a robot maps of one building of rooms, in an even unknown.
  const grid::PixelImage drawn = grid::DecodePng(enfilade::testing::DrawPlan().png).value();
  const int margin = 100, width = drawn.width + 2 * margin, height = drawn.height + 2 * margin;
  std::vector<std::uint8_t> map(static_cast<std::size_t>(width) * height, 205);
  for (int y = 0; y < drawn.height; ++y) {
    for (int x = 0; x < drawn.width; ++x) {
      map[static_cast<std::size_t>(y + margin) * width + x + margin] =
          drawn.samples[static_cast<std::size_t>(y) * drawn.width + x];
    }
  }
  const auto robot_map = DecodePlan(Png(width, height, map));
  ASSERT_TRUE(robot_map.ok()) << robot_map.status();
  EXPECT_FALSE(robot_map->graph.H_sheet_photo.has_value());
}

}  // namespace
}  // namespace enfilade::perception
