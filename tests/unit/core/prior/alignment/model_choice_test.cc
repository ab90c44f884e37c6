// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/model_choice.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <random>

#include "tests/support/plans/drawn_building.h"

namespace enfilade::prior {
namespace {

// `ratio`: of the scale along the sheet's x by that along its y.
PlanTransform Sheared(double ratio, double shear) {
  const double root = std::sqrt(ratio);
  Eigen::Matrix2d distortion;
  distortion << root, shear, shear, 1 / root;
  PlanTransform transform;
  transform.linear =
      0.05 * Eigen::Rotation2Dd(0.3).toRotationMatrix() * Eigen::Vector2d(1, -1).asDiagonal() * distortion;
  transform.offset = {3.5, -7.25};
  return transform;
}

bool IsMapped(const Eigen::Vector2d& sheet) { return sheet.x() < 600; }

// The corners of a plan as people draw it: off by `sigma`, in units of the sheet.
PlanGraph DrawnAgain(PlanGraph plan, double sigma, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> off(0, sigma);
  for (PlanCorner& corner : plan.corners) corner.point += Eigen::Vector2d(off(random), off(random));
  return plan;
}

double MostOff(const PlanGraph& plan, const PlanTransform& found, const PlanTransform& truth) {
  double largest = 0;
  for (const PlanCorner& corner : plan.corners)
    largest = std::max(largest, (found(corner.point) - truth(corner.point)).norm());
  return largest;
}

PlacedModel Chosen(const PlanGraph& plan, const PlanTransform& truth, TransformModel widest) {
  const MapEvidence evidence = EvidenceOf(MapOf(DrawnBuilding(), truth, IsMapped));
  return ChooseModel(FacesOf(plan), evidence, {truth, TransformModel::kSimilarity}, widest);
}

TEST(ChooseModelTest, AnAccuratePlanIsNotDistorted) {
  const PlanGraph plan = DrawnBuilding();
  const PlacedModel chosen = Chosen(plan, Sheared(1, 0), TransformModel::kAffine);
  EXPECT_EQ(chosen.model, TransformModel::kSimilarity);
  EXPECT_LT(MostOff(plan, chosen.T_map_sheet, Sheared(1, 0)), 0.1);
}

TEST(ChooseModelTest, EachAxisHasItsScaleIfThatExplainsWhatWasHeldBack) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    const PlanGraph plan = DrawnAgain(DrawnBuilding(), 1.0, seed);
    const PlacedModel chosen = Chosen(plan, Sheared(1.04, 0), TransformModel::kAffine);
    EXPECT_NE(chosen.model, TransformModel::kSimilarity);
    EXPECT_LT(MostOff(plan, chosen.T_map_sheet, Sheared(1.04, 0)), 0.3);
  }
}

TEST(ChooseModelTest, AShearedPlanIsSheared) {
  const PlacedModel chosen = Chosen(DrawnBuilding(), Sheared(1.02, 0.03), TransformModel::kAffine);
  EXPECT_EQ(chosen.model, TransformModel::kAffine);
}

TEST(ChooseModelTest, GivesNoMoreFreedomThanIsAllowed) {
  const PlacedModel chosen = Chosen(DrawnBuilding(), Sheared(1.04, 0), TransformModel::kSimilarity);
  EXPECT_EQ(chosen.model, TransformModel::kSimilarity);
  EXPECT_TRUE(IsSimilarity(chosen.T_map_sheet));
}

TEST(ChooseModelTest, AMapWithTooFewWallsChangesNothing) {
  const PlanTransform truth = Sheared(1.04, 0);
  MapEvidence evidence = EvidenceOf(MapOf(DrawnBuilding(), truth, IsMapped));
  evidence.walls.resize(100);
  const PlacedModel chosen =
      ChooseModel(FacesOf(DrawnBuilding()), evidence, {truth, TransformModel::kAnisotropic}, TransformModel::kAffine);
  EXPECT_EQ(chosen.model, TransformModel::kAnisotropic);
  EXPECT_EQ(chosen.T_map_sheet.linear, truth.linear);
}

}  // namespace
}  // namespace enfilade::prior
