// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/plan_localizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "core/prior/localization/plan_start.h"
#include "core/prior/localization/submap_tracking.h"
#include "tests/support/plans/drawn_building.h"
#include "tests/unit/core/prior/localization/driven_plan.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

// Through a room, the corridor, another room, and on to the end of the corridor.
const std::vector<Vector2d> kWay = {{2.5, 5},      {2.5, 11.25},  {13.5, 11.25}, {13.5, 6},
                                    {13.5, 11.25}, {28.5, 11.25}, {28.5, 17}};

PlanLocalizerOptions QuickOptions(PlanSight sight) {
  PlanLocalizerOptions options;
  options.sight = sight;
  options.global_density = 700;
  return options;
}

// The plan as its mirror image.
PlanGraph Mirrored(PlanGraph plan) {
  for (PlanCorner& corner : plan.corners) corner.point.x() = 900 - corner.point.x();
  return plan;
}

// Two corners of the drawn building, where the robot's map has them, each a click's error off.
std::vector<ControlPair> Clicks(const DrivenPlan& building, const Pose2& start) {
  std::vector<ControlPair> pairs;
  const Vector2d errors[] = {{0.25, -0.2}, {-0.2, 0.3}};
  const Vector2d corners[] = {{0, 200}, {260, 200}};
  for (int i = 0; i < 2; ++i)
    pairs.push_back({corners[i], Inverse(start) * building.InBuilding(corners[i]) + errors[i]});
  return pairs;
}

struct Outcome {
  PlanPosterior last;
  std::vector<PlanPosterior> steps;
  std::vector<PlanParticle> particles;
};

Outcome Locate(const PlanField& field, const std::vector<ControlPair>& pairs, const Driven& driven,
               const PlanLocalizerOptions& options) {
  PlanLocalizer localizer(field, pairs, options);
  Outcome outcome;
  for (const PlanLook& look : driven.looks) outcome.steps.push_back(localizer.Add(look));
  outcome.last = outcome.steps.back();
  outcome.particles = localizer.particles();
  return outcome;
}

// m of the building, if the plan's sheet is that of the building.
double ErrorOf(const PlanField& field, const DrivenPlan& building, const PlanMode& mode, const Pose2& truth) {
  return (building.InBuilding(field.ToSheet(mode.mean.translation())) - truth.translation()).norm();
}

class PlanLocalizerModels : public ::testing::TestWithParam<PlanSight> {};
INSTANTIATE_TEST_SUITE_P(Models, PlanLocalizerModels, ::testing::Values(PlanSight::kField, PlanSight::kNdt),
                         [](const auto& one) { return std::string(NameOf(one.param)); });

TEST_P(PlanLocalizerModels, FollowsADriveFromTwoClicks) {
  const DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, kWay);
  const std::vector<ControlPair> pairs = Clicks(building, driven.truth.front());
  const auto unit = NominalScale(building.plan, pairs);
  ASSERT_TRUE(unit.ok()) << unit.status();
  const PlanField field(building.plan, *unit);
  const Outcome outcome = Locate(field, pairs, driven, QuickOptions(GetParam()));
  EXPECT_TRUE(outcome.last.confident);
  EXPECT_LT(ErrorOf(field, building, outcome.last.modes.front(), driven.truth.back()), 0.4);
  EXPECT_NEAR(outcome.last.modes.front().mean.yaw, driven.truth.back().yaw, 0.1);
  EXPECT_NEAR(std::log(*unit) + outcome.last.modes.front().mean.log_scale, std::log(0.05), 0.05);
  for (std::size_t i = 0; i < outcome.steps.size(); ++i) {
    if (!outcome.steps[i].confident) continue;
    EXPECT_LT(ErrorOf(field, building, outcome.steps[i].modes.front(), driven.truth[i]), 1.0) << i;
  }
}

TEST_P(PlanLocalizerModels, FindsTheRobotAnywhereInAPlanAtAWrongScale) {
  DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, kWay);
  building.plan.metres_per_unit = 0.05 / 1.15;
  const PlanField field(building.plan, *NominalScale(building.plan, {}));
  const Outcome outcome = Locate(field, {}, driven, QuickOptions(GetParam()));
  EXPECT_TRUE(outcome.last.confident);
  EXPECT_LT(ErrorOf(field, building, outcome.last.modes.front(), driven.truth.back()), 0.5);
  EXPECT_NEAR(outcome.last.modes.front().mean.log_scale, std::log(1.15), 0.05);
  EXPECT_FALSE(outcome.last.modes.front().mean.mirrored);
}

TEST_P(PlanLocalizerModels, FindsTheRobotInAMirroredPlan) {
  const DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, kWay);
  PlanGraph plan = Mirrored(building.plan);
  plan.metres_per_unit = 0.05;
  const PlanField field(plan, 0.05);
  const Outcome outcome = Locate(field, {}, driven, QuickOptions(GetParam()));
  EXPECT_TRUE(outcome.last.confident);
  for (std::size_t i = 0; i < outcome.steps.size(); ++i) {
    if (!outcome.steps[i].confident) continue;
    const PlanState& mean = outcome.steps[i].modes.front().mean;
    EXPECT_TRUE(mean.mirrored) << i;
    const Vector2d sheet = field.ToSheet(mean.translation());
    EXPECT_LT((building.InBuilding({900 - sheet.x(), sheet.y()}) - driven.truth[i].translation()).norm(), 1.0) << i;
  }
}

TEST(PlanLocalizerTest, ACorridorStaysOpenAlongIt) {
  DrivenPlan building;
  building.plan.corners = {{{0, 0}}, {{1600, 0}}, {{0, 50}}, {{1600, 50}}};  // 80 m x 2.5 m
  building.plan.walls = {{.from = 0, .to = 1}, {.from = 2, .to = 3}};
  building.plan.metres_per_unit = 0.05;
  const Driven driven = DriveAlong(building, {{30, 1.25}, {50, 1.25}});
  const PlanField field(building.plan, 0.05);
  const Outcome outcome = Locate(field, {}, driven, QuickOptions(PlanSight::kField));
  for (const PlanPosterior& step : outcome.steps) EXPECT_FALSE(step.confident);
  double mass = 0;
  double spread = 0;  // along the corridor
  double mean = 0;
  for (const PlanParticle& particle : outcome.particles) mean += particle.weight * particle.state.x;
  for (const PlanParticle& particle : outcome.particles) {
    spread += particle.weight * (particle.state.x - mean) * (particle.state.x - mean);
    if (std::abs(-particle.state.y - 1.25) < 0.5) mass += particle.weight;
  }
  EXPECT_GT(std::sqrt(spread), 8.0);
  EXPECT_GT(mass, 0.9);
}

TEST(PlanLocalizerTest, HalvesThatLookAlikeKeepTwoModes) {
  DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, {{2.5, 5}, {2.5, 11.25}, {13.5, 11.25}});
  // The same building once more beside it.
  const std::size_t count = building.plan.corners.size();
  for (std::size_t i = 0; i < count; ++i)
    building.plan.corners.push_back({building.plan.corners[i].point + Vector2d(1200, 0)});
  for (PlanWall wall : std::vector(building.plan.walls)) {
    wall.from += static_cast<int>(count);
    wall.to += static_cast<int>(count);
    building.plan.walls.push_back(wall);
  }
  const PlanField field(building.plan, 0.05);
  const Outcome outcome = Locate(field, {}, driven, QuickOptions(PlanSight::kField));
  for (const PlanPosterior& step : outcome.steps) EXPECT_FALSE(step.confident);
  const Vector2d truth = driven.truth.back().translation();
  double first = 0;
  double second = 0;
  for (const PlanMode& mode : outcome.last.modes) {
    const Vector2d at = building.InBuilding(field.ToSheet(mode.mean.translation()));
    if ((at - truth).norm() < 1.0) first += mode.mass;
    if ((at - truth - Vector2d(60, 0)).norm() < 1.0) second += mode.mass;
  }
  EXPECT_GT(first, 0.05);
  EXPECT_GT(second, 0.05);
  EXPECT_GT(first + second, 0.8);
}

TEST_P(PlanLocalizerModels, TheSameInputGivesTheSameBytes) {
  const DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, {{2.5, 5}, {2.5, 11.25}, {6, 11.25}});
  const PlanField field(building.plan, 0.05);
  PlanLocalizerOptions options = QuickOptions(GetParam());
  const Outcome first = Locate(field, {}, driven, options);
  const Outcome second = Locate(field, {}, driven, options);
  const auto is_same = [](const std::vector<PlanParticle>& a, const std::vector<PlanParticle>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PlanParticle& p, const PlanParticle& q) {
      return p.weight == q.weight && p.state.x == q.state.x && p.state.y == q.state.y && p.state.yaw == q.state.yaw &&
             p.state.log_scale == q.state.log_scale && p.state.log_stretch == q.state.log_stretch &&
             p.state.mirrored == q.state.mirrored;
    });
  };
  EXPECT_TRUE(is_same(first.particles, second.particles));
  options.seed = 2;
  EXPECT_FALSE(is_same(first.particles, Locate(field, {}, driven, options).particles));
}

TEST(PlanLocalizerTest, NothingIsSaidBeforeTheRobotHasDriven) {
  const DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, {{2.5, 5}, {2.5, 6}});
  const PlanField field(building.plan, 0.05);
  const Outcome outcome = Locate(field, {}, driven, QuickOptions(PlanSight::kField));
  EXPECT_EQ(outcome.last.particles, 0U);
  EXPECT_TRUE(outcome.last.modes.empty());
  EXPECT_FALSE(outcome.last.confident);
}

TEST(PlanLocalizerTest, OnePairSaysWhereTheRobotIsButNotItsTurn) {
  const DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, kWay);
  const std::vector<ControlPair> pairs = {{{50, 100}, {0, 0}}};
  const PlanField field(building.plan, 0.05);
  PlanLocalizer localizer(field, pairs, QuickOptions(PlanSight::kField));
  localizer.Add(driven.looks.front());
  double turns = 0;
  for (const PlanParticle& particle : localizer.particles()) {
    EXPECT_LT((building.InBuilding(field.ToSheet(particle.state.translation())) - Vector2d(2.5, -5)).norm(), 2.0);
    turns += std::cos(particle.state.yaw) * particle.weight;
  }
  EXPECT_LT(std::abs(turns), 0.1);
  PlanPosterior last;
  for (std::size_t i = 1; i < driven.looks.size(); ++i) last = localizer.Add(driven.looks[i]);
  EXPECT_TRUE(last.confident);
  EXPECT_LT(ErrorOf(field, building, last.modes.front(), driven.truth.back()), 0.5);
}

// The walls around the start of the way, as a submap whose frame is the first pose.
std::vector<Vector2d> SubmapPoints(const Driven& driven, std::size_t looks) {
  std::vector<Vector2d> points;
  for (std::size_t i = 0; i < looks; ++i) {
    for (const Vector2d& hit : driven.looks[i].hits) points.push_back(driven.looks[i].T_map_robot * hit);
  }
  return points;
}

TEST(TrackSubmapTest, ASubmapIsMovedOntoThePlansWalls) {
  for (const bool mirrored : {false, true}) {
    const DrivenPlan building{DrawnBuilding()};
    const Driven driven = DriveAlong(building, kWay);
    const PlanField field(mirrored ? Mirrored(building.plan) : building.plan, 0.05);
    const Pose2 start = driven.truth.front();
    PlanState truth{.x = start.x, .y = start.y, .yaw = start.yaw};
    if (mirrored) truth = {.x = 45 - start.x, .y = start.y, .yaw = WrapAngle(M_PI - start.yaw), .mirrored = true};
    PlanState guess = truth;
    guess.x += 0.2;
    guess.y -= 0.15;
    guess.yaw += 0.03;
    const TrackedSubmap tracked = TrackSubmap(field, SubmapPoints(driven, 40), guess, {});
    EXPECT_TRUE(tracked.accepted);
    EXPECT_LT((tracked.state.translation() - truth.translation()).norm(), 0.06);
    EXPECT_NEAR(WrapAngle(tracked.state.yaw - truth.yaw), 0, 0.01);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tracked.information).eigenvalues().x(), 1.0);
  }
}

TEST(TrackSubmapTest, ASubmapOfACorridorSaysNothingAlongIt) {
  DrivenPlan building;
  building.plan.corners = {{{0, 0}}, {{1600, 0}}, {{0, 50}}, {{1600, 50}}};
  building.plan.walls = {{.from = 0, .to = 1}, {.from = 2, .to = 3}};
  const Driven driven = DriveAlong(building, {{30, 1.25}, {36, 1.25}});
  const PlanField field(building.plan, 0.05);
  const TrackedSubmap tracked = TrackSubmap(field, SubmapPoints(driven, 20), {.x = 30.5, .y = -1.2}, {});
  EXPECT_NEAR(tracked.state.y, -1.25, 0.03);
  EXPECT_LT(tracked.information(0, 0), 1e-3 * tracked.information(1, 1));
}

TEST(LocateDriveTest, SubmapsThatAreDoneAreTracked) {
  const DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, kWay);
  MappedDrive mapped;
  std::vector<DriveSubmap>& submaps = mapped.submaps;
  for (std::size_t i = 0; i < driven.looks.size(); ++i) {
    const auto id = static_cast<std::int64_t>(i / 40);
    if (i % 40 == 0) submaps.push_back({id, driven.looks[i].T_map_robot, {}});
    mapped.looks.push_back({driven.looks[i], id});
    const Pose2 T_submap_robot = Between(submaps.back().T_map_submap, driven.looks[i].T_map_robot);
    for (const Vector2d& hit : driven.looks[i].hits) submaps.back().points.push_back(T_submap_robot * hit);
  }
  const std::vector<ControlPair> pairs = Clicks(building, driven.truth.front());
  const PlanField field(building.plan, *NominalScale(building.plan, pairs));
  const auto drive = LocateDrive(field, pairs, mapped, QuickOptions(PlanSight::kField));
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_GE(drive->submaps.size(), 2U);
  for (const TrackedSubmap& tracked : drive->submaps) {
    EXPECT_TRUE(tracked.accepted);
    const Pose2& truth = driven.truth[static_cast<std::size_t>(tracked.submap) * 40];
    EXPECT_LT((building.InBuilding(field.ToSheet(tracked.state.translation())) - truth.translation()).norm(), 0.3);
  }
}

TEST(LocateDriveTest, EndsWithinASearchWhenNobodyWaits) {
  const DrivenPlan building{DrawnBuilding()};
  const Driven driven = DriveAlong(building, kWay);
  MappedDrive mapped;
  for (const PlanLook& look : driven.looks) mapped.looks.push_back({look, 0});
  const PlanField field(building.plan, 0.05);
  // Asked once for each look; the first search of the whole plan asks more often.
  int asked = 0;
  const auto drive = LocateDrive(field, {}, mapped, QuickOptions(PlanSight::kField), [&]() -> absl::Status {
    return ++asked < 12 ? absl::OkStatus() : absl::CancelledError("nobody waits");
  });
  EXPECT_EQ(drive.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(asked, 13) << "the search has ended at once, and the drive after its look";
}

TEST(NominalScaleTest, IsThatOfThePairsOrThePlanOrItsDoors) {
  PlanGraph plan = DrawnBuilding();
  EXPECT_THAT(std::string(NominalScale(plan, {}).status().message()), ::testing::HasSubstr("does not tell its scale"));
  plan.doors = {{{0, 0}, {18, 0}}, {{0, 0}, {20, 0}}, {{0, 0}, {40, 0}}};
  EXPECT_NEAR(*NominalScale(plan, {}), 0.9 / 20, 1e-12);
  plan.metres_per_unit = 0.05;
  EXPECT_EQ(*NominalScale(plan, {}), 0.05);
  EXPECT_NEAR(*NominalScale(plan, {{{0, 0}, {0, 0}}, {{400, 0}, {24, 0}}}), 0.06, 1e-9);
  EXPECT_EQ(NominalScale(plan, {{{0, 0}, {0, 0}}, {{0, 0}, {24, 0}}}).status().code(),
            absl::StatusCode::kInvalidArgument);
  plan.metres_per_unit = 50;
  EXPECT_THAT(std::string(NominalScale(plan, {}).status().message()), ::testing::HasSubstr("at most 500 m"));
}

}  // namespace
}  // namespace enfilade::prior
