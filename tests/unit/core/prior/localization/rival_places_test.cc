// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/rival_places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/prior/localization/plan_localizer.h"
#include "tests/support/plans/drawn_building.h"
#include "tests/unit/core/prior/localization/driven_plan.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

const std::vector<Vector2d> kTwinWay = {{2.5, 5}, {2.5, 11.25}, {13.5, 11.25}, {13.5, 6}, {13.5, 11.25}, {28.5, 11.25}};
constexpr double kTwinUnit = 0.05;  // m

// Where a point of the building (sheet, m) is drawn: up to 0.2 m off, here to one side, there to the other.
Vector2d Bent(const Vector2d& p) {
  return p + 0.2 * Vector2d(std::sin(2 * M_PI * p.y() / 17), std::sin(2 * M_PI * p.x() / 19));
}
// Where its twin has it: turned by half, beside it.
Vector2d InTwin(const Vector2d& p) { return {100 - p.x(), 24 - p.y()}; }

// The drawn building, drawn wrong, and beside it another that is the same turned by half. That one is drawn right, but
// has walls across the way, which the building has not, if `odd`.
PlanGraph PlanWithTwin(bool bent, bool odd) {
  PlanGraph plan = DrawnBuilding();
  const std::size_t count = plan.walls.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d from = kTwinUnit * plan.corners[static_cast<std::size_t>(plan.walls[i].from)].point;
    const Vector2d to = kTwinUnit * plan.corners[static_cast<std::size_t>(plan.walls[i].to)].point;
    DrawWall(plan, InTwin(from) / kTwinUnit, InTwin(to) / kTwinUnit);
  }
  if (bent) {
    for (std::size_t i = 0; i < 2 * count; ++i)
      plan.corners[i].point = Bent(kTwinUnit * plan.corners[i].point) / kTwinUnit;
  }
  const auto odd_wall = [&](double x0, double y0, double x1, double y1) {
    if (odd) DrawWall(plan, InTwin({x0, y0}) / kTwinUnit, InTwin({x1, y1}) / kTwinUnit);
  };
  odd_wall(0, 6, 5, 6), odd_wall(0, 8, 5, 8), odd_wall(6, 10, 6, 12.5), odd_wall(10, 10, 10, 12.5);
  odd_wall(0.5, 11.25, 33, 11.25);
  odd_wall(12, 8, 16, 8), odd_wall(18, 10, 18, 12.5), odd_wall(21, 10, 21, 12.5), odd_wall(24, 10, 24, 12.5);
  plan.metres_per_unit = kTwinUnit;
  return plan;
}

struct TwinDrive {
  DrivenPlan building{DrawnBuilding()};
  Driven driven = DriveAlong(building, kTwinWay);

  PlanState Right() const {
    const Pose2& truth = driven.truth.back();
    const Vector2d at = Bent({truth.x, -truth.y});
    return {.x = at.x(), .y = -at.y(), .yaw = truth.yaw};
  }
  PlanState Wrong() const {
    const Pose2& truth = driven.truth.back();
    const Vector2d at = InTwin({truth.x, -truth.y});
    return {.x = at.x(), .y = -at.y(), .yaw = WrapAngle(truth.yaw + M_PI)};
  }
};

PlaceVerdict VerdictOn(const PlanField& field, const TwinDrive& drive, const PlanState& asked,
                       const std::vector<ControlPair>& pairs = {}, const KeepGoing& keep_going = {}) {
  RivalPlaces rivals(field, pairs, {}, keep_going);
  for (const PlanLook& look : drive.driven.looks) rivals.Add(look, 0);
  return rivals.Compare({{.mass = 1, .mean = asked}}, drive.driven.looks.back().T_map_robot, false);
}

double OffBy(const PlanField& field, const TwinDrive& drive, const PlanTransform& place, const PlanState& state) {
  const PlanState found = StateAt(field, place, drive.driven.looks.back().T_map_robot);
  return (found.translation() - state.translation()).norm() + 5 * std::abs(WrapAngle(found.yaw - state.yaw));
}

TEST(PlaceOfTest, IsUndoneByStateAt) {
  const PlanField field(DrawnBuilding(), kTwinUnit);
  const Pose2 T_map_robot{3, -2, 0.7};
  for (const bool mirrored : {false, true}) {
    const PlanState state{.x = 12, .y = -7, .yaw = 2.5, .log_scale = 0.1, .log_stretch = -0.07, .mirrored = mirrored};
    const PlanTransform place = PlaceOf(field, state, T_map_robot);
    EXPECT_EQ(place.mirrored(), mirrored);
    EXPECT_LT((place(field.ToSheet(state.translation())) - T_map_robot.translation()).norm(), 1e-9);
    // What is a metre ahead of the robot there is a metre ahead of it here.
    const Vector2d ahead = state.translation() + LinearOf(state, field.axis()) * Vector2d(1, 0.5);
    EXPECT_LT((place(field.ToSheet(ahead)) - T_map_robot * Vector2d(1, 0.5)).norm(), 1e-9);
    const PlanState back = StateAt(field, place, T_map_robot);
    EXPECT_NEAR(back.x, state.x, 1e-9);
    EXPECT_NEAR(back.y, state.y, 1e-9);
    EXPECT_NEAR(back.yaw, state.yaw, 1e-9);
    EXPECT_NEAR(back.log_scale, state.log_scale, 1e-9);
    EXPECT_NEAR(back.log_stretch, state.log_stretch, 1e-9);
    EXPECT_EQ(back.mirrored, mirrored);
  }
}

TEST(RivalPlacesTest, TheRightOfTwoTwinsIsProven) {
  const TwinDrive drive;
  const PlanField field(PlanWithTwin(true, true), kTwinUnit);
  const PlaceVerdict verdict = VerdictOn(field, drive, drive.Right());
  ASSERT_TRUE(verdict.proven);
  EXPECT_TRUE(verdict.likelier.empty());
  EXPECT_LT(OffBy(field, drive, *verdict.proven, drive.Right()), 1.0);
}

TEST(RivalPlacesTest, TheWrongOneGivesWayToTheRightOne) {
  const TwinDrive drive;
  const PlanField field(PlanWithTwin(true, true), kTwinUnit);
  const PlaceVerdict verdict = VerdictOn(field, drive, drive.Wrong());
  ASSERT_EQ(verdict.likelier.size(), 1U);
  EXPECT_LT(OffBy(field, drive, verdict.likelier.front(), drive.Right()), 1.0);
}

TEST(RivalPlacesTest, NothingIsProvenOfExactTwins) {
  const TwinDrive drive;
  const PlanField field(PlanWithTwin(false, false), kTwinUnit);
  const PlaceVerdict verdict = VerdictOn(field, drive, drive.Wrong());
  EXPECT_FALSE(verdict.proven);
  EXPECT_TRUE(verdict.likelier.empty());
}

TEST(RivalPlacesTest, NoRivalIsFarFromWhereOnePairSays) {
  const TwinDrive drive;
  const PlanField field(PlanWithTwin(false, false), kTwinUnit);
  const Vector2d start(2.5, 5);
  const PlaceVerdict verdict = VerdictOn(field, drive, drive.Wrong(), {{InTwin(start) / kTwinUnit, {0, 0}}});
  ASSERT_TRUE(verdict.proven);
  EXPECT_LT(OffBy(field, drive, *verdict.proven, drive.Wrong()), 1.0);
}

TEST(RivalPlacesTest, NothingIsProvenWhenNobodyWaits) {
  const TwinDrive drive;
  const PlanField field(PlanWithTwin(true, true), kTwinUnit);
  int asked = 0;
  const PlaceVerdict verdict = VerdictOn(field, drive, drive.Right(), {}, [&]() -> absl::Status {
    return ++asked < 5 ? absl::OkStatus() : absl::CancelledError("nobody waits");
  });
  EXPECT_FALSE(verdict.proven);
  EXPECT_TRUE(verdict.likelier.empty());
  EXPECT_GE(asked, 5);
}

// Ends of beams match the twin's walls, which are drawn right; that it has too many does not count.
TEST(RivalPlacesTest, ADriveIsNeverCertainOfTheWrongTwin) {
  const TwinDrive drive;
  const PlanField field(PlanWithTwin(true, true), kTwinUnit);
  const auto wrong_steps = [&](bool compare_rivals) {
    PlanLocalizerOptions options;
    options.global_density = 300;
    options.compare_rivals = compare_rivals;
    PlanLocalizer localizer(field, {}, options);
    int wrong = 0;
    for (std::size_t i = 0; i < drive.driven.looks.size(); ++i) {
      const PlanPosterior step = localizer.Add(drive.driven.looks[i]);
      const Pose2& truth = drive.driven.truth[i];
      const Vector2d right = Bent({truth.x, -truth.y});
      wrong += step.confident && (step.modes.front().mean.translation() - Vector2d(right.x(), -right.y())).norm() > 1.5;
    }
    return wrong;
  };
  EXPECT_GT(wrong_steps(false), 0) << "as it is drawn, the plan explains more at the wrong place";
  EXPECT_EQ(wrong_steps(true), 0);
}

}  // namespace
}  // namespace enfilade::prior
