// SPDX-License-Identifier: Apache-2.0
// Maps of simulated buildings whose places in each other are known, and drawn corridors that look alike.
#include "core/localization/alignment/align_maps.h"

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "core/base/noise.h"
#include "gmock/gmock.h"
#include "tests/support/buildings/mapped_building.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/localization/drawn_map.h"

namespace enfilade::localization {
namespace {

using enfilade::testing::MapPair;
using enfilade::testing::PoseNear;
using enfilade::testing::TwoMapsOfABuilding;
using ::testing::HasSubstr;

// Not those that the options were chosen with.
constexpr std::uint64_t kFirstSeed = 9100;
constexpr int kBuildings = 24;

AlignableMap Alignable(const grid::OccupancyGrid& grid) { return AlignableMap(grid, LocalizationOptions()); }

MapAlignment Align(const grid::OccupancyGrid& a, const grid::OccupancyGrid& b, const AlignmentGuess& guess) {
  const auto found = AlignMaps(Alignable(a), Alignable(b), guess, {}, GoOn);
  EXPECT_OK(found);
  return found.value_or(MapAlignment());
}

Pose2 MiddleOf(const AlignableMap& map) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : map.ground()) sum += point;
  const Eigen::Vector2d middle = sum / static_cast<double>(map.ground().size());
  return {middle.x(), middle.y(), 0.0};
}

struct Error {
  double distance = 0.0;  // m, at the middle of map b
  double yaw = 0.0;       // rad
  double chi2 = 0.0;      // of the position there
};

// `guess_off`: where a person has put the middle of map b.
std::optional<Error> ErrorOf(const MapPair& pair, const Pose2& guess_off) {
  const Pose2 T_b_middle = MiddleOf(Alignable(pair.b));
  const Pose2 T_a_middle = pair.T_a_b * T_b_middle;
  const MapAlignment found = Align(pair.a, pair.b, {T_a_middle * guess_off * Inverse(T_b_middle)});
  if (!found.accepted) return std::nullopt;
  const PoseWithCovariance at_middle = Compose(*found.T_a_b, {T_b_middle, Eigen::Matrix3d::Zero()});
  const Eigen::Vector2d off = at_middle.pose.translation() - T_a_middle.translation();
  return Error{off.norm(), std::abs(WrapAngle(at_middle.pose.yaw - T_a_middle.yaw)),
               off.dot(at_middle.covariance.topLeftCorner<2, 2>().inverse() * off)};
}

TEST(AlignMapsTest, FindsThePlaceFromAGuessThatIsOffBy3MetresAnd20Degrees) {
  int accepted = 0;
  int in_ellipse = 0;
  for (int i = 0; i < kBuildings; ++i) {
    const std::uint64_t seed = kFirstSeed + static_cast<std::uint64_t>(i);
    Noise noise(seed);
    const double direction = noise.Uniform(-M_PI, M_PI);
    const double turn = (noise.Chance(0.5) ? 20.0 : -20.0) * kDegree;
    const auto error = ErrorOf(TwoMapsOfABuilding(seed), {3.0 * std::cos(direction), 3.0 * std::sin(direction), turn});
    if (!error) continue;
    ++accepted;
    in_ellipse += error->chi2 < 5.991 ? 1 : 0;
    EXPECT_LT(error->distance, 0.05) << "building " << seed;
    EXPECT_LT(error->yaw, 0.5 * kDegree) << "building " << seed;
  }
  EXPECT_GE(accepted, kBuildings - 2) << "nearly all of them fit at one place only";
  EXPECT_GE(in_ellipse, accepted - 2) << "the covariance is honest";
}

TEST(AlignMapsTest, TheCovarianceIsOfTheFramesAndNotVague) {
  const MapPair pair = TwoMapsOfABuilding(kFirstSeed + 50);
  const MapAlignment found = Align(pair.a, pair.b, {pair.T_a_b});
  ASSERT_TRUE(found.accepted) << found.reason;
  const Eigen::Vector3d off(found.T_a_b->pose.x - pair.T_a_b.x, found.T_a_b->pose.y - pair.T_a_b.y,
                            WrapAngle(found.T_a_b->pose.yaw - pair.T_a_b.yaw));
  EXPECT_LT(off.dot(found.T_a_b->covariance.inverse() * off), 11.34) << "99 % of chi-squared";
  const PoseWithCovariance at_middle = Compose(*found.T_a_b, {MiddleOf(Alignable(pair.b)), Eigen::Matrix3d::Zero()});
  EXPECT_LT(std::sqrt(at_middle.covariance(0, 0)), 0.06);
  EXPECT_LT(std::sqrt(at_middle.covariance(2, 2)), 0.5 * kDegree);
  EXPECT_GT(found.overlap, 5.0);
  // A link point there lies on free ground of both.
  const Eigen::Vector2d place_b = Inverse(found.T_a_b->pose) * found.place_a;
  EXPECT_EQ(Alignable(pair.a).searchable().At(found.place_a), SearchableMap::Cell::kFree);
  EXPECT_EQ(Alignable(pair.b).searchable().At(place_b), SearchableMap::Cell::kFree);
}

TEST(AlignMapsTest, FindsAMapThatWasGuessedTheWrongWayRound) {
  const MapPair pair = TwoMapsOfABuilding(kFirstSeed + 51);
  const Pose2 T_b_middle = MiddleOf(Alignable(pair.b));
  const MapAlignment found =
      Align(pair.a, pair.b, {pair.T_a_b * T_b_middle * Pose2{0.5, 0.5, M_PI + 0.1} * Inverse(T_b_middle)});
  ASSERT_TRUE(found.accepted) << found.reason;
  EXPECT_THAT(found.T_a_b->pose * T_b_middle, PoseNear(pair.T_a_b * T_b_middle, 0.05, 0.5 * kDegree));
}

TEST(AlignMapsTest, MapsOfTwoBuildingsAreRefused) {
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + 12; ++seed) {
    const grid::OccupancyGrid a = TwoMapsOfABuilding(seed).a;
    const grid::OccupancyGrid b = TwoMapsOfABuilding(seed + 500).b;
    const Pose2 guess = MiddleOf(Alignable(a)) * Inverse(MiddleOf(Alignable(b)));
    const MapAlignment found = Align(a, b, {guess});
    EXPECT_FALSE(found.accepted) << seed << ": " << found.reason;
    EXPECT_NE(found.reason, "");
  }
}

// A corridor along x of `length` characters, with an alcove as wide as a door, 1 m, and 0.75 m deep in the upper wall
// at each of `alcoves`. Its ends are open: nobody has seen them.
DrawnMap Corridor(std::size_t length, const std::vector<std::size_t>& alcoves) {
  constexpr std::size_t kDeep = 3;
  const std::string unknown(length, '?'), wall(length, '#'), ground(length, ' ');
  std::vector<std::string> rows(kDeep + 1, unknown);
  rows.insert(rows.end(), {wall, ground, ground, ground, ground, ground, ground, wall, unknown});
  for (const std::size_t alcove : alcoves) {
    rows[0].replace(alcove - 1, 6, "######");
    for (std::size_t row = 1; row <= kDeep; ++row) rows[row].replace(alcove - 1, 6, "#    #");
    rows[kDeep + 1].replace(alcove, 4, "    ");
  }
  return DrawnMap(rows);
}

TEST(AlignMapsTest, ABareCorridorSlides) {
  const MapAlignment found = Align(Corridor(120, {}).Grid(), Corridor(60, {}).Grid(), {{5.0, 0.0, 0.0}});
  EXPECT_FALSE(found.accepted);
  EXPECT_TRUE(found.T_a_b) << "they fit, but where?";
  EXPECT_NE(found.reason, "");
}

TEST(AlignMapsTest, IdenticalStretchesOfACorridorAreAmbiguous) {
  // Alcoves every 4 m: shifted by 4 m it fits as well.
  const MapAlignment found = Align(Corridor(160, {8, 24, 40, 56, 72, 88, 104, 120, 136}).Grid(),
                                   Corridor(64, {8, 24, 40, 56}).Grid(), {{8.0, 0.3, 0.1}});
  EXPECT_FALSE(found.accepted);
  EXPECT_THAT(found.reason, HasSubstr("ambiguous"));
  EXPECT_LT(found.rival_ratio, 1.5);
}

TEST(AlignMapsTest, IdenticalUnitsThatOverlapByOneAreAmbiguousThoughMoreWouldFitShifted) {
  // Truth: the last unit of a is the first of b. Both have the same three units, so that all three fit as well.
  const MapAlignment found = Align(Corridor(96, {8, 17, 40, 49, 72, 81}).Grid(),
                                   Corridor(96, {8, 17, 40, 49, 72, 81}).Grid(), {{6.0, 0.0, 0.0}, 12.0, 0.5});
  EXPECT_FALSE(found.accepted) << found.reason;
}

TEST(AlignMapsTest, UnevenAlcovesFixACorridor) {
  const std::vector<std::size_t> alcoves = {8, 20, 47, 63, 90, 97, 121};
  // b begins 40 characters into a.
  const MapAlignment found =
      Align(Corridor(130, alcoves).Grid(), Corridor(90, {7, 23, 50, 57, 81}).Grid(), {{8.0, 1.0, 0.2}});
  ASSERT_TRUE(found.accepted) << found.reason;
  EXPECT_THAT(found.T_a_b->pose, PoseNear(Pose2{10.0, 0.0, 0.0}, 0.05, 0.5 * kDegree));
}

TEST(AlignMapsTest, ACorridorThatLooksTheSameFromBothEndsIsAmbiguous) {
  const DrawnMap corridor({"##########################", "#                        #", "#                        #",
                           "#      ##        ##      #", "#      ##        ##      #", "#                        #",
                           "#                        #", "##########################"});
  const MapAlignment found = Align(corridor.Grid(), corridor.Grid(), {{0.3, 0.2, 0.1}});
  EXPECT_FALSE(found.accepted);
  EXPECT_THAT(found.reason, HasSubstr("turned round"));
}

TEST(AlignMapsTest, MapsWithoutWallsOrFarApartAreRefusedWithAReason) {
  const grid::OccupancyGrid room = UniqueRoom().Grid();
  grid::OccupancyGrid empty = room;
  for (std::uint8_t& cell : empty.cells) cell = grid::kUnknownCell;
  EXPECT_THAT(Align(room, empty, {}).reason, HasSubstr("map b has no walls"));
  EXPECT_THAT(Align(empty, room, {}).reason, HasSubstr("map a has no walls"));
  const MapAlignment far = Align(room, room, {{500.0, 0.0, 0.0}});
  EXPECT_FALSE(far.accepted);
  EXPECT_FALSE(far.T_a_b);
  EXPECT_THAT(far.reason, HasSubstr("guess"));
}

TEST(AlignMapsTest, RefusesAGuessThatIsOutOfRangeAndStopsWhenAsked) {
  const AlignableMap room = Alignable(UniqueRoom().Grid());
  const auto status = [&](const AlignmentGuess& guess) { return AlignMaps(room, room, guess, {}, GoOn).status(); };
  EXPECT_STATUS(status({{}, 0.0, 0.5}), absl::StatusCode::kInvalidArgument, HasSubstr("radius_m is 0"));
  EXPECT_STATUS(status({{}, 20.5, 0.5}), absl::StatusCode::kInvalidArgument, HasSubstr("radius_m"));
  EXPECT_STATUS(status({{}, 5.0, 3.2}), absl::StatusCode::kInvalidArgument, HasSubstr("yaw_range_rad is 3.2"));
  EXPECT_STATUS(status({{std::nan(""), 0.0, 0.0}}), absl::StatusCode::kInvalidArgument, HasSubstr("pose_a_b"));
  EXPECT_CODE(AlignMaps(room, room, {}, {}, [] { return absl::CancelledError("enough"); }),
              absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace enfilade::localization
