// SPDX-License-Identifier: Apache-2.0
#include "core/geo/georeference.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/support/status_assertions.h"

namespace enfilade::geo {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

// Control points of a site whose frame is rotated by `yaw` and whose coordinates start at `offset`.
std::vector<SurveyPoint> Points(double yaw, const Eigen::Vector2d& offset, double scale = 1.0) {
  const TransverseMercator projection({.longitude = 9.7, .latitude = 52.37});
  std::vector<SurveyPoint> points;
  for (const Eigen::Vector2d& p : std::vector<Eigen::Vector2d>{{0, 0}, {120, 10}, {90, 80}, {-15, 60}}) {
    const Eigen::Vector2d ground = Pose2{1000.0, -500.0, yaw} * Eigen::Vector2d(scale * p);
    points.push_back({.place = projection.Inverse(ground), .p_world = p + offset});
  }
  return points;
}

TEST(GeoreferenceTest, FindsTheRotation) {
  for (const double yaw : {0.0, 0.7, -2.9, 3.1}) {
    ASSERT_OK_AND_ASSIGN(const GeoreferenceFit fit, FitGeoreference(Points(yaw, {0, 0})));
    // The projections' meridians differ by 1 km, and so north by 0.01 degrees.
    EXPECT_NEAR(std::remainder(fit.georeference.yaw() - yaw, 2 * M_PI), 0.0, 3e-4);
    EXPECT_NEAR(fit.best_scale, 1.0, 1e-6);
    EXPECT_LT(fit.rms_m, 1e-4);
    EXPECT_THAT(fit.residual_m, SizeIs(4));
  }
}

TEST(GeoreferenceTest, CoordinatesAsLargeAsUtmsKeepTheirPrecision) {
  const Eigen::Vector2d utm(548713.123456, 5802345.678901);
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit near, FitGeoreference(Points(0.3, {0, 0})));
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit far, FitGeoreference(Points(0.3, utm)));
  const TransverseMercator ground({.longitude = 9.7, .latitude = 52.37});
  for (const Eigen::Vector2d& d : std::vector<Eigen::Vector2d>{{0, 0}, {33.333, 1.001}, {-5000, 7000}}) {
    const Eigen::Vector2d expected = ground.Forward(near.georeference.ToLonLat(d));
    EXPECT_LT((ground.Forward(far.georeference.ToLonLat(utm + d)) - expected).norm(), 1e-6) << d.transpose();
  }
}

TEST(GeoreferenceTest, TheLargestResidualMarksAMisplacedPoint) {
  std::vector<SurveyPoint> points = Points(0.3, {0, 0});
  points[2].p_world.x() += 2.0;
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit fit, FitGeoreference(points));
  EXPECT_GT(fit.residual_m[2], 1.0);
  for (const int i : {0, 1, 3}) EXPECT_LT(fit.residual_m[static_cast<std::size_t>(i)], fit.residual_m[2]);
}

TEST(GeoreferenceTest, EstimatesTheScaleOnlyOnRequest) {
  const std::vector<SurveyPoint> points = Points(0.3, {0, 0}, 1.02);
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit rigid, FitGeoreference(points));
  EXPECT_NEAR(rigid.best_scale, 1.02, 1e-4);
  EXPECT_EQ(rigid.georeference.scale(), 1.0);
  EXPECT_GT(rigid.rms_m, 0.1);
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit similar, FitGeoreference(points, {.estimate_scale = true}));
  EXPECT_LT(similar.rms_m, 1e-4);
}

TEST(GeoreferenceTest, RefusesTooFewOrTooClosePoints) {
  const std::vector<SurveyPoint> good = Points(0.3, {0, 0});
  EXPECT_CODE(FitGeoreference({}), absl::StatusCode::kInvalidArgument);
  EXPECT_STATUS(FitGeoreference({good[0]}), absl::StatusCode::kInvalidArgument, HasSubstr("at least two"));
  EXPECT_STATUS(FitGeoreference({good[0], good[0]}), absl::StatusCode::kInvalidArgument, HasSubstr("apart"));
  std::vector<SurveyPoint> same_place = {good[0], good[1]};
  same_place[1].place = same_place[0].place;
  EXPECT_STATUS(FitGeoreference(same_place), absl::StatusCode::kInvalidArgument, HasSubstr("apart"));
}

TEST(GeoreferenceTest, RefusesImpossiblePoints) {
  std::vector<SurveyPoint> exchanged = Points(0.3, {0, 0});
  for (SurveyPoint& point : exchanged) std::swap(point.place.longitude, point.place.latitude);
  EXPECT_CODE(FitGeoreference(exchanged), absl::StatusCode::kInvalidArgument);
  std::vector<SurveyPoint> mirrored = Points(0.3, {0, 0});
  for (SurveyPoint& point : mirrored) std::swap(point.p_world.x(), point.p_world.y());
  EXPECT_STATUS(FitGeoreference(mirrored), absl::StatusCode::kInvalidArgument, HasSubstr("mirror"));
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 200.0, -91.0}) {
    std::vector<SurveyPoint> points = Points(0.3, {0, 0});
    points[1].place.latitude = bad;
    EXPECT_CODE(FitGeoreference(points), absl::StatusCode::kInvalidArgument) << bad;
  }
  std::vector<SurveyPoint> points = Points(0.3, {0, 0});
  points[0].p_world.y() = std::nan("");
  EXPECT_CODE(FitGeoreference(points), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace enfilade::geo
