// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/correct_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/prior/correction/displacement_field.h"
#include "tests/support/plans/drawn_building.h"

namespace enfilade::prior {
namespace {

constexpr double kMetresPerUnit = 0.05;  // m
const PlanTransform kWherePlanLies{Eigen::Vector2d(kMetresPerUnit, -kMetresPerUnit).asDiagonal(), {3.5, -7.25}};

MapEvidence AllOf(const PlanGraph& building) {
  return EvidenceOf(MapOf(building, kWherePlanLies, [](const Eigen::Vector2d&) { return true; }));
}

double AcrossOf(const CorrectedPlan& corrected, const PlanGraph& plan, std::size_t wall, const Eigen::Vector2d& sheet) {
  const Eigen::Vector2d from = corrected.corners()[static_cast<std::size_t>(plan.walls[wall].from)].point;
  const Eigen::Vector2d to = corrected.corners()[static_cast<std::size_t>(plan.walls[wall].to)].point;
  const Eigen::Vector2d along = (to - from).normalized();
  return std::abs(Eigen::Vector2d(-along.y(), along.x()).dot(kWherePlanLies(sheet) - from));
}

// A cupboard 0.45 m deep hides the half of a wall of 3.5 m; the map knows no ground behind its front.
TEST(CorrectPlanTest, FurnitureBeforeAWallDoesNotBendIt) {
  PlanGraph building = DrawnBuilding();
  DrawWall(building, {600, 20}, {670, 20});
  PlanGraph plan = building;
  const std::size_t wall = plan.walls.size() - 1;
  const auto is_hidden = [](const Eigen::Vector2d& p) {
    return p.x() > 635 && p.x() < 672 && p.y() > 0 && p.y() < 28.5;
  };
  PlanGraph furnished = building;
  DrawWall(furnished, {635, 29}, {670, 29});
  const MapEvidence evidence =
      EvidenceOf(MapOf(furnished, kWherePlanLies, [&](const Eigen::Vector2d& p) { return !is_hidden(p); }));
  const CorrectedPlan corrected(plan, evidence, kWherePlanLies);
  EXPECT_LT(AcrossOf(corrected, plan, wall, {600, 20}), 0.1);
  EXPECT_LT(AcrossOf(corrected, plan, wall, {670, 20}), 0.1);
}

// Each face of a thick wall makes the other look less straight.
TEST(CorrectPlanTest, AThickWallIsNotTakenForItsOtherFace) {
  PlanGraph building = DrawnBuilding();
  PlanGraph plan = building;
  DrawWall(plan, {420, 100}, {460, 100});
  plan.walls.back().thickness = 5;  // 0.25 m
  for (const double y : {97.5, 102.5}) DrawWall(building, {420, y}, {460, y});
  for (const double x : {420.0, 460.0}) DrawWall(building, {x, 97.5}, {x, 102.5});
  const auto is_inside = [](const Eigen::Vector2d& p) {
    return p.x() > 420.5 && p.x() < 459.5 && p.y() > 98 && p.y() < 102;
  };
  const MapEvidence evidence =
      EvidenceOf(MapOf(building, kWherePlanLies, [&](const Eigen::Vector2d& p) { return !is_inside(p); }));
  const std::size_t wall = plan.walls.size() - 1;
  for (const int end : {plan.walls[wall].from, plan.walls[wall].to}) {
    plan.corners[static_cast<std::size_t>(end)].point.y() += 3;  // nearer to its other face
  }
  const CorrectedPlan corrected(plan, evidence, kWherePlanLies);
  EXPECT_LT(AcrossOf(corrected, plan, wall, {440, 100}), 0.1);
}

TEST(LogEvidenceTest, AMetreInFreeGroundCostsLnTen) {
  const PlanGraph building = DrawnBuilding();
  const MapEvidence evidence = AllOf(building);
  PlanGraph invented = building;
  DrawWall(invented, {560, 100}, {660, 100});  // 5 m
  const double cost =
      LogEvidenceOf(building, evidence, kWherePlanLies) - LogEvidenceOf(invented, evidence, kWherePlanLies);
  EXPECT_NEAR(cost, 5 * std::log(10), 0.5);
}

TEST(LogEvidenceTest, EachSeenWallAddsToIt) {
  const PlanGraph building = DrawnBuilding();
  const MapEvidence evidence = AllOf(building);
  PlanGraph incomplete = building;
  incomplete.walls.pop_back();  // 2 m
  EXPECT_GT(LogEvidenceOf(building, evidence, kWherePlanLies), LogEvidenceOf(incomplete, evidence, kWherePlanLies) + 1);
}

TEST(LogEvidenceTest, BendingCosts) {
  const PlanGraph building = DrawnBuilding();
  const MapEvidence evidence = AllOf(building);
  PlanGraph bent = building;
  for (PlanCorner& corner : bent.corners) corner.point.x() += 6 * std::sin(corner.point.x() / 40);  // up to 0.3 m
  const CorrectedPlan exact(building, evidence, kWherePlanLies);
  const CorrectedPlan corrected(bent, evidence, kWherePlanLies);
  EXPECT_GT(corrected.agreement().explained, 0.95);  // it can be bent back
  EXPECT_GT(exact.log_evidence(), corrected.log_evidence() + 20);
}

TEST(LogEvidenceTest, IsLowerWhereThePlanDoesNotLie) {
  const PlanGraph building = DrawnBuilding();
  const MapEvidence evidence = AllOf(building);
  const PlanTransform turned_over{Eigen::Vector2d(-kMetresPerUnit, -kMetresPerUnit).asDiagonal(), {3.5 + 44, -7.25}};
  EXPECT_GT(LogEvidenceOf(building, evidence, kWherePlanLies), LogEvidenceOf(building, evidence, turned_over) + 100);
}

PlanOffset OffsetAt(double x, double offset) {
  return {.place = {.point = {x, 0}}, .normal = {0, 1}, .offset = offset, .sigma = 0.05};
}

TEST(LogOddsToChanceTest, AnOffsetThatChanceExplainsBetterCountsNothing) {
  const double log_chance = -std::log(2.4);
  std::vector<PlanOffset> offsets;
  for (int i = -5; i <= 5; ++i) offsets.push_back(OffsetAt(i, 0.01 * (i % 3)));
  const double without = DisplacementField({}, offsets, {}).LogOddsToChance(log_chance);
  EXPECT_NEAR(without, DisplacementField({}, offsets, {}).log_likelihood() - 11 * log_chance, 1e-9);  // all count
  // In the middle of the others, so that the distortion of the whole is about the same point.
  offsets.push_back(OffsetAt(0, 0.3));
  offsets.push_back(OffsetAt(0, -0.4));
  EXPECT_LT(DisplacementField({}, offsets, {}).log_likelihood() - 13 * log_chance, without - 20);
  EXPECT_NEAR(DisplacementField({}, offsets, {}).LogOddsToChance(log_chance), without, 1e-6);
}

}  // namespace
}  // namespace enfilade::prior
