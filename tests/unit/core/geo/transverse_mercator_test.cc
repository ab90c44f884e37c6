// SPDX-License-Identifier: Apache-2.0
#include "core/geo/transverse_mercator.h"

#include <gmock/gmock.h>

#include <vector>

namespace enfilade::geo {
namespace {

// PROJ 9.1.1: +proj=tmerc +ellps=WGS84 +k=1 with lat_0, lon_0 of the origin.
TEST(TransverseMercatorTest, AgreesWithAnotherImplementation) {
  struct Row {
    LonLat origin;
    LonLat place;
    Eigen::Vector2d east_north;
  };
  const std::vector<Row> table = {
      {{9.7, 52.37}, {9.75, 52.4}, {3403.210378, 3339.416185}},
      {{9.7, 52.37}, {12.0, 50.0}, {164892.582423, -261130.798092}},
      {{-75.0, -33.5}, {-74.2, -33.9}, {73995.238219, -44654.925892}},
      {{179.9, 65.0}, {-179.8, 65.2}, {14046.714627, 22332.205518}},
      {{0.0, 0.0}, {3.0, 0.5}, {334099.541550, 55363.533629}},
      {{25.0, 80.0}, {40.0, 82.0}, {230602.246628, 253403.015959}},
  };
  for (const Row& row : table) {
    const TransverseMercator projection(row.origin);
    EXPECT_LT((projection.Forward(row.place) - row.east_north).norm(), 2e-6) << row.place.longitude;
    const LonLat back = projection.Inverse(row.east_north);
    EXPECT_NEAR(back.longitude, row.place.longitude, 1e-10);
    EXPECT_NEAR(back.latitude, row.place.latitude, 1e-10);
  }
}

TEST(TransverseMercatorTest, ThereAndBackIsTheSame) {
  for (double latitude = -85.0; latitude <= 85.0; latitude += 17.0) {
    const TransverseMercator projection({.longitude = 100.0, .latitude = latitude});
    for (double east = -50000.0; east <= 50000.0; east += 12500.0) {
      const Eigen::Vector2d point(east, 0.7 * east + 321.0);
      EXPECT_LT((projection.Forward(projection.Inverse(point)) - point).norm(), 1e-7) << latitude << ", " << east;
    }
  }
}

TEST(TransverseMercatorTest, TheOriginIsTheOrigin) {
  const TransverseMercator projection({.longitude = -71.1, .latitude = 42.36});
  EXPECT_LT(projection.Forward({-71.1, 42.36}).norm(), 1e-9);
}

}  // namespace
}  // namespace enfilade::geo
