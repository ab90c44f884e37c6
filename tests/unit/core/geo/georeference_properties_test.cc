// SPDX-License-Identifier: Apache-2.0
// Georeferences of random sites, and of places whose coordinates are published.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/geo/georeference.h"
#include "tests/support/status_assertions.h"

namespace enfilade::geo {
namespace {

using ::testing::HasSubstr;

// UTM is the transverse Mercator projection about a zone's meridian with scale 0.9996 and 500 km added to the east.
Eigen::Vector2d Utm(const LonLat& place, double meridian) {
  const Eigen::Vector2d east_north = TransverseMercator({.longitude = meridian, .latitude = 0.0}).Forward(place);
  return 0.9996 * east_north + Eigen::Vector2d(500'000.0, 0.0);
}

TEST(TransverseMercatorUtm, AgreesWithPublishedCoordinates) {
  struct Row {
    const char* name;
    LonLat place;
    double meridian;
    Eigen::Vector2d utm;
  };
  // GeoConvert of GeographicLib's documentation, and the worked example of Ordnance Survey's and USGS's tables.
  for (const Row& row : {Row{"Baghdad", {44.4, 33.3}, 45.0, {444140.54, 3684706.36}},
                         Row{"the equator on a meridian", {9.0, 0.0}, 9.0, {500000.0, 0.0}},
                         Row{"the zone's edge on the equator", {6.0, 0.0}, 9.0, {166021.44, 0.0}}}) {
    EXPECT_LT((Utm(row.place, row.meridian) - row.utm).norm(), 0.02) << row.name;
  }
}

TEST(TransverseMercatorProperties, HasScaleOneOnItsMeridian) {
  // WGS84's meridian arcs from the equator: 1 degree at the equator, 45 degrees, and near the pole.
  const TransverseMercator projection({.longitude = -30.0, .latitude = 0.0});
  EXPECT_NEAR(projection.Forward({-30.0, 1.0}).y(), 110574.3886, 1e-3);
  EXPECT_NEAR(projection.Forward({-30.0, 45.0}).y(), 4984944.3780, 1e-3);
  EXPECT_NEAR(projection.Forward({-30.0, 90.0}).y(), 10001965.7293, 1e-3);
  for (double latitude = -80.0; latitude <= 80.0; latitude += 10.0) {
    EXPECT_NEAR(projection.Forward({-30.0, latitude}).x(), 0.0, 1e-9) << latitude;
    EXPECT_NEAR(projection.Forward({-30.0, latitude}).y(), -projection.Forward({-30.0, -latitude}).y(), 1e-6);
  }
}

TEST(TransverseMercatorProperties, IsSymmetricAboutTheMeridian) {
  const TransverseMercator projection({.longitude = 170.0, .latitude = 40.0});
  for (double difference = 0.5; difference < 6.0; difference += 0.5) {
    const Eigen::Vector2d east = projection.Forward({170.0 + difference, 41.0});
    const Eigen::Vector2d west = projection.Forward({170.0 - difference, 41.0});
    EXPECT_NEAR(east.x(), -west.x(), 1e-6);
    EXPECT_NEAR(east.y(), west.y(), 1e-6);
    EXPECT_GT(east.x(), 0.0);
  }
}

TEST(TransverseMercatorProperties, CrossesTheAntimeridian) {
  const TransverseMercator projection({.longitude = 179.99, .latitude = -17.0});
  const Eigen::Vector2d beyond = projection.Forward({-179.99, -17.0});
  EXPECT_NEAR(beyond.x(), 0.02 * M_PI / 180.0 * 6378137.0 * std::cos(17.0 * M_PI / 180.0), 10.0);
  const LonLat back = projection.Inverse(beyond);
  EXPECT_NEAR(back.longitude, -179.99, 1e-10);
  EXPECT_NEAR(back.latitude, -17.0, 1e-10);
}

struct Site {
  Pose2 T_ground_world;  // of the world frame on the ground, about `origin`
  LonLat origin;
  std::vector<Eigen::Vector2d> points;  // in the world frame
};

Site RandomSite(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Site site;
  site.origin = {.longitude = 180.0 * unit(random), .latitude = 80.0 * unit(random)};
  site.T_ground_world = {500.0 * unit(random), 500.0 * unit(random), M_PI * unit(random)};
  for (std::uint64_t i = 0; i < 3 + random() % 5; ++i)
    site.points.emplace_back(300.0 * unit(random), 200.0 * unit(random));
  return site;
}

std::vector<SurveyPoint> Survey(const Site& site) {
  const TransverseMercator projection(site.origin);
  std::vector<SurveyPoint> points;
  for (const Eigen::Vector2d& p : site.points) {
    points.push_back({.place = projection.Inverse(site.T_ground_world * p), .p_world = p});
  }
  return points;
}

class SiteSeeds : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Sites, SiteSeeds, ::testing::Range(1U, 26U));

TEST_P(SiteSeeds, ExactControlPointsAreReproduced) {
  std::mt19937_64 random(GetParam());
  const Site site = RandomSite(random);
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit fit, FitGeoreference(Survey(site)));
  EXPECT_NEAR(fit.best_scale, 1.0, 1e-6);
  EXPECT_LT(fit.rms_m, 1e-3);
  const TransverseMercator ground(site.origin);
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0, 0), Eigen::Vector2d(123.4, -56.7), Eigen::Vector2d(-300, 250)}) {
    const Eigen::Vector2d put = ground.Forward(fit.georeference.ToLonLat(p));
    EXPECT_LT((put - site.T_ground_world * p).norm(), 2e-3) << p.transpose();
  }
}

TEST_P(SiteSeeds, TheOrderOfControlPointsDoesNotMatter) {
  std::mt19937_64 random(GetParam() + 100);
  std::vector<SurveyPoint> points = Survey(RandomSite(random));
  for (SurveyPoint& point : points) point.p_world.x() += 0.2 * static_cast<double>(random() % 100) / 100.0;
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit fit, FitGeoreference(points));
  std::shuffle(points.begin(), points.end(), random);
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit shuffled, FitGeoreference(points));
  EXPECT_NEAR(shuffled.rms_m, fit.rms_m, 1e-6);
  EXPECT_NEAR(std::remainder(shuffled.georeference.yaw() - fit.georeference.yaw(), 2.0 * M_PI), 0.0, 1e-8);
}

TEST_P(SiteSeeds, NoOtherRotationFitsBetter) {
  std::mt19937_64 random(GetParam() + 200);
  std::normal_distribution<double> noise(0.0, 0.3);
  const Site site = RandomSite(random);
  std::vector<SurveyPoint> points = Survey(site);
  for (SurveyPoint& point : points) point.p_world += Eigen::Vector2d(noise(random), noise(random));
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit fit, FitGeoreference(points));
  const TransverseMercator ground(site.origin);
  Eigen::Vector2d world_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d ground_mean = Eigen::Vector2d::Zero();
  for (const SurveyPoint& point : points) {
    world_mean += point.p_world / static_cast<double>(points.size());
    ground_mean += ground.Forward(point.place) / static_cast<double>(points.size());
  }
  // The fit's yaw in the frame of `ground`, whose meridian differs a little.
  const Eigen::Vector2d along = ground.Forward(fit.georeference.ToLonLat(world_mean + Eigen::Vector2d(10, 0))) -
                                ground.Forward(fit.georeference.ToLonLat(world_mean));
  const auto error = [&](double yaw) {
    double sum = 0.0;
    for (const SurveyPoint& point : points) {
      const Eigen::Vector2d put = Pose2{ground_mean.x(), ground_mean.y(), yaw} * (point.p_world - world_mean);
      sum += (put - ground.Forward(point.place)).squaredNorm();
    }
    return sum;
  };
  const double yaw = std::atan2(along.y(), along.x());
  for (const double change : {-0.1, -0.01, -0.001, 0.001, 0.01, 0.1}) EXPECT_GE(error(yaw + change), error(yaw) - 1e-6);
}

TEST_P(SiteSeeds, TheEstimatedScaleIsTheSitesScale) {
  std::mt19937_64 random(GetParam() + 300);
  const double scale = 0.95 + 0.001 * static_cast<double>(random() % 100);
  std::vector<SurveyPoint> points = Survey(RandomSite(random));
  for (SurveyPoint& point : points) point.p_world /= scale;
  ASSERT_OK_AND_ASSIGN(const GeoreferenceFit fit, FitGeoreference(points, {.estimate_scale = true}));
  EXPECT_NEAR(fit.georeference.scale(), scale, 1e-6);
  EXPECT_NEAR(fit.best_scale, scale, 1e-6);
  EXPECT_LT(fit.rms_m, 1e-3);
  for (SurveyPoint& point : points) point.p_world *= 1.2;
  EXPECT_STATUS(FitGeoreference(points, {.estimate_scale = true}), absl::StatusCode::kInvalidArgument,
                HasSubstr("times as far apart"));
}

}  // namespace
}  // namespace enfilade::geo
