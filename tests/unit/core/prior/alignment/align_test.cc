// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/align.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/prior/correction/correct_plan.h"
#include "tests/support/plans/drawn_building.h"

namespace enfilade::prior {
namespace {

PlanTransform Turned(double turn, double scale, bool mirrored) {
  PlanTransform transform;
  Eigen::Matrix2d rotation;
  rotation << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
  transform.linear = scale * rotation * Eigen::Vector2d(1, mirrored ? 1 : -1).asDiagonal();
  transform.offset = {3.5, -7.25};
  return transform;
}

// Where robots have been: all but the right third.
bool IsLeft(const Eigen::Vector2d& sheet) { return sheet.x() < 600; }

double LargestError(const PlanGraph& plan, const PlanTransform& found, const PlanTransform& truth) {
  double largest = 0;
  for (const PlanCorner& corner : plan.corners)
    largest = std::max(largest, (found(corner.point) - truth(corner.point)).norm());
  return largest;
}

struct Case {
  double turn;
  double scale;
  bool mirrored;
};

class AlignByItself : public testing::TestWithParam<Case> {};

TEST_P(AlignByItself, FindsThePlanInTheMap) {
  const PlanGraph plan = DrawnBuilding();
  const PlanTransform truth = Turned(GetParam().turn, GetParam().scale, GetParam().mirrored);
  const MapEvidence evidence = EvidenceOf(MapOf(plan, truth, IsLeft));
  const Alignment alignment = prior::AlignByItself(plan, evidence, {});
  EXPECT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_EQ(alignment.T_map_sheet.mirrored(), GetParam().mirrored);
  EXPECT_LT(LargestError(plan, alignment.T_map_sheet, truth), 0.2);
  EXPECT_GT(alignment.agreement.explained, 0.95);
  EXPECT_EQ(alignment.model, TransformModel::kSimilarity);
}

INSTANTIATE_TEST_SUITE_P(Turns, AlignByItself,
                         testing::Values(Case{0.3, 0.05, false}, Case{2.0, 0.04, false}, Case{-1.1, 0.06, true}));

// Of a similarity, and of a plan that only the stretched search finds.
TEST(AlignByItselfTest, TheResultDoesNotDependOnTheNumberOfThreads) {
  for (const double stretch : {1.0, 1.25}) {
    const PlanGraph plan = DrawnBuilding();
    PlanTransform truth = Turned(0.3, 0.05, false);
    truth.linear.col(0) *= stretch;
    const MapEvidence evidence = EvidenceOf(MapOf(plan, truth, IsLeft));
    AlignOptions options;
    options.log_evidence = &LogEvidenceOf;
    const Alignment one = prior::AlignByItself(plan, evidence, options);
    options.threads = 4;
    const Alignment four = prior::AlignByItself(plan, evidence, options);
    EXPECT_EQ(one.accepted, four.accepted);
    EXPECT_EQ(one.reason, four.reason);
    EXPECT_EQ(one.T_map_sheet.linear, four.T_map_sheet.linear);
    EXPECT_EQ(one.T_map_sheet.offset, four.T_map_sheet.offset);
    EXPECT_EQ(one.rival_ratio, four.rival_ratio);
    EXPECT_EQ(one.agreement.explained, four.agreement.explained);
  }
}

// Of a sheet on which the building is turned by `turn`.
PlanTransform Stretched(double turn, double ratio) {
  PlanTransform transform = Turned(0.3, 0.05, false);
  const Eigen::Matrix2d axes = Eigen::Rotation2Dd(turn).toRotationMatrix();
  const double root = std::sqrt(ratio);
  transform.linear = transform.linear * Eigen::Vector2d(root, 1 / root).asDiagonal() * axes.transpose();
  return transform;
}

PlanGraph TurnedOnTheSheet(PlanGraph plan, double turn) {
  for (PlanCorner& corner : plan.corners) corner.point = Eigen::Rotation2Dd(turn) * corner.point;
  return plan;
}

TEST(AlignByItselfTest, FindsAPlanWhoseAxesHaveDifferentScales) {
  const PlanGraph plan = DrawnBuilding();
  for (const auto& [ratio, turn] : {std::pair(0.75, 0.0), std::pair(1.35, 0.5)}) {
    const PlanTransform truth = Stretched(turn, ratio);
    const PlanGraph turned = TurnedOnTheSheet(plan, turn);
    const MapEvidence evidence = EvidenceOf(MapOf(plan, Stretched(0, ratio), IsLeft));
    const Alignment alignment = prior::AlignByItself(turned, evidence, {});
    EXPECT_TRUE(alignment.accepted) << ratio << " " << turn << ": " << alignment.reason;
    EXPECT_LT(LargestError(turned, alignment.T_map_sheet, truth), 0.3) << ratio << " " << turn;
  }
}

TEST(AlignByItselfTest, ASecondMapIsFoundWithTheShapeThatTheFirstOneTells) {
  const PlanGraph plan = DrawnBuilding();
  const PlanTransform shape = Stretched(0, 1.3);
  const PlanTransform truth = Pose2{4.0, -9.0, 1.2} * shape;
  const AlignOptions options{.known_shape = shape};
  const Alignment alignment = prior::AlignByItself(plan, EvidenceOf(MapOf(plan, truth, IsLeft)), options);
  EXPECT_TRUE(alignment.accepted) << alignment.reason;
  EXPECT_LT(LargestError(plan, alignment.T_map_sheet, truth), 0.2);
}

// It would fit best if the plan were a tenth larger.
TEST(AlignByItselfTest, AKnownShapeKeepsItsSize) {
  const PlanGraph plan = DrawnBuilding();
  const PlanTransform shape = Turned(0.4, 0.05, false);
  const MapEvidence evidence = EvidenceOf(MapOf(plan, Turned(0.4, 0.055, false), IsLeft));
  const Alignment alignment = prior::AlignByItself(plan, evidence, {.known_shape = shape});
  EXPECT_NEAR(alignment.T_map_sheet.scale() / shape.scale(), 1, kKnownScale + 1e-9) << alignment.reason;
}

TEST(AlignByItselfTest, APlaceOfAKnownShapeMustAlsoBeTheLikeliest) {
  const PlanGraph plan = DrawnBuilding();
  const PlanTransform shape = Turned(0.4, 0.05, false);
  const MapEvidence evidence = EvidenceOf(MapOf(plan, Pose2{4.0, -9.0, 1.2} * shape, IsLeft));
  AlignOptions options{.known_shape = shape};
  options.log_evidence = &LogEvidenceOf;
  EXPECT_TRUE(prior::AlignByItself(plan, evidence, options).accepted);
  options.log_evidence = [](const PlanGraph&, const MapEvidence&, const PlanTransform&) { return 10.0; };
  const Alignment alignment = prior::AlignByItself(plan, evidence, options);
  EXPECT_FALSE(alignment.accepted);
  EXPECT_THAT(alignment.reason, testing::HasSubstr("the plan is nearly as likely: log odds 0, 9 are needed"));
}

TEST(PlanTransformTest, IsASimilarityWithoutItsDistortion) {
  const PlanTransform similarity = Turned(0.7, 0.05, true);
  EXPECT_TRUE(IsSimilarity(similarity));
  PlanTransform stretched = similarity;
  stretched.linear = similarity.linear * Eigen::Vector2d(1.25, 0.8).asDiagonal();
  EXPECT_FALSE(IsSimilarity(stretched));
  const Eigen::Vector2d fixed(12, -3);
  const PlanTransform found = AsSimilarity(stretched, fixed);
  EXPECT_LT((found.linear - similarity.linear).norm(), 1e-12);
  EXPECT_LT((found(ToSheet(stretched, fixed)) - fixed).norm(), 1e-9);
}

TEST(AlignByItselfTest, RefusesAMapOfAnotherBuilding) {
  const PlanGraph plan = DrawnBuilding();
  PlanGraph other;
  for (int i = 0; i < 9; ++i) {
    const int first = static_cast<int>(other.corners.size());
    const double x = 60.0 * i;
    other.corners.push_back({{x, 0}});
    other.corners.push_back({{x, 300}});
    other.walls.push_back({.from = first, .to = first + 1});
  }
  other.corners.push_back({{0, 0}});
  other.corners.push_back({{480, 0}});
  other.walls.push_back({.from = 18, .to = 19});
  const Alignment alignment = prior::AlignByItself(
      plan, EvidenceOf(MapOf(other, Turned(0.4, 0.05, false), [](const auto&) { return true; })), {});
  EXPECT_FALSE(alignment.accepted);
  EXPECT_FALSE(alignment.reason.empty());
}

TEST(AlignByItselfTest, RefusesABareRoomThatFitsInManyPlaces) {
  const PlanGraph plan = DrawnBuilding();
  // Only the first room of the corridor.
  const MapEvidence evidence = EvidenceOf(
      MapOf(plan, Turned(0.3, 0.05, false), [](const Eigen::Vector2d& p) { return p.x() < 102 && p.y() < 202; }));
  EXPECT_FALSE(prior::AlignByItself(plan, evidence, {}).accepted);
}

TEST(AlignByPairsTest, ClicksThatAreOffAreMovedOntoTheWalls) {
  const PlanGraph plan = DrawnBuilding();
  const PlanTransform truth = Turned(0.7, 0.05, false);
  const MapEvidence evidence = EvidenceOf(MapOf(plan, truth, IsLeft));
  const std::vector<ControlPair> pairs = {{{0, 0}, truth(Eigen::Vector2d(0, 0)) + Eigen::Vector2d(0.3, -0.2)},
                                          {{520, 200}, truth(Eigen::Vector2d(520, 200)) + Eigen::Vector2d(-0.3, 0.25)}};
  const auto alignment = prior::AlignByPairs(plan, evidence, pairs, {});
  ASSERT_TRUE(alignment.ok()) << alignment.status();
  EXPECT_LT(LargestError(plan, alignment->T_map_sheet, truth), 0.2);
}

TEST(AlignByPairsTest, WallsTellWhetherAPlanIsMirrored) {
  const PlanGraph plan = DrawnBuilding();
  for (const bool mirrored : {false, true}) {
    const PlanTransform truth = Turned(0.7, 0.05, mirrored);
    const MapEvidence evidence = EvidenceOf(MapOf(plan, truth, IsLeft));
    // Two pairs fit both ways.
    const std::vector<ControlPair> pairs = {{{0, 0}, truth(Eigen::Vector2d(0, 0))},
                                            {{520, 200}, truth(Eigen::Vector2d(520, 200))}};
    const auto alignment = prior::AlignByPairs(plan, evidence, pairs, {});
    ASSERT_TRUE(alignment.ok()) << alignment.status();
    EXPECT_EQ(alignment->T_map_sheet.mirrored(), mirrored);
    EXPECT_LT(LargestError(plan, alignment->T_map_sheet, truth), 0.2);
  }
}

// Both points lie on one wall, so nothing but the map's walls tells the scale across it.
TEST(AlignByPairsTest, TheScalesOfAPlanThatLiesAskewOnItsSheetMayDiffer) {
  const PlanGraph plan = DrawnBuilding();
  const auto on_sheet = [](const Eigen::Vector2d& p) -> Eigen::Vector2d { return Eigen::Rotation2Dd(M_PI / 4) * p; };
  const PlanGraph turned = TurnedOnTheSheet(plan, M_PI / 4);
  for (const double ratio : {0.7, 1.4, 1.5}) {
    const PlanTransform truth = Stretched(M_PI / 4, ratio);
    const MapEvidence evidence = EvidenceOf(MapOf(
        plan, [&](const Eigen::Vector2d& p) { return truth(on_sheet(p)); }, IsLeft));
    std::vector<ControlPair> pairs;
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), {240, 0}}) {
      pairs.push_back({on_sheet(point), truth(on_sheet(point))});
    }
    const auto alignment = prior::AlignByPairs(turned, evidence, pairs, {});
    ASSERT_TRUE(alignment.ok()) << alignment.status();
    EXPECT_LT(LargestError(turned, alignment->T_map_sheet, truth), 0.5) << ratio;
  }
}

// The robot has seen one room of it.
TEST(AlignByPairsTest, FourPairsTellTheScalesOfAPlanThatLiesAskewOnItsSheet) {
  const PlanGraph plan = DrawnBuilding();
  const auto on_sheet = [](const Eigen::Vector2d& p) -> Eigen::Vector2d { return Eigen::Rotation2Dd(M_PI / 4) * p; };
  const PlanGraph turned = TurnedOnTheSheet(plan, M_PI / 4);
  for (const double ratio : {0.75, 1.3}) {
    const PlanTransform truth = Stretched(M_PI / 4, ratio);
    const MapEvidence evidence = EvidenceOf(MapOf(
        plan, [&](const Eigen::Vector2d& p) { return truth(on_sheet(p)); },
        [](const Eigen::Vector2d& p) { return p.x() < 102 && p.y() < 202; }));
    std::vector<ControlPair> pairs;
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), {520, 0}, {0, 480}, {480, 480}}) {
      pairs.push_back({on_sheet(point), truth(on_sheet(point)) + Eigen::Vector2d(0.1, -0.1)});
    }
    const auto alignment = prior::AlignByPairs(turned, evidence, pairs, {});
    ASSERT_TRUE(alignment.ok()) << alignment.status();
    EXPECT_LT(LargestError(turned, alignment->T_map_sheet, truth), 0.3) << ratio;
  }
}

TEST(AlignByPairsTest, FourPairsStretchNoPlanThatOnlyASimilarityMayPlace) {
  const PlanGraph plan = DrawnBuilding();
  const PlanTransform truth = Stretched(0, 1.3);
  const MapEvidence evidence = EvidenceOf(MapOf(plan, truth, [](const Eigen::Vector2d&) { return true; }));
  std::vector<ControlPair> pairs;
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), {520, 0}, {0, 480}, {480, 480}}) {
    pairs.push_back({point, truth(point)});
  }
  AlignOptions options;
  options.widest_model = TransformModel::kSimilarity;
  const auto alignment = prior::AlignByPairs(plan, evidence, pairs, options);
  ASSERT_TRUE(alignment.ok()) << alignment.status();
  EXPECT_EQ(alignment->model, TransformModel::kSimilarity);
  EXPECT_TRUE(IsSimilarity(alignment->T_map_sheet));
}

// Of which a robot has seen two parallel walls.
TEST(AlignByPairsTest, ABareCorridorStaysOpenAlongIt) {
  PlanGraph plan = DrawnBuilding();
  plan.metres_per_unit = 0.5;
  const PlanTransform truth = Turned(0.7, 0.05, false);
  const MapEvidence evidence = EvidenceOf(MapOf(
      plan, truth, [](const Eigen::Vector2d& p) { return p.y() > 198 && p.y() < 252 && p.x() > 100 && p.x() < 600; }));
  const Eigen::Vector2d along = truth.linear.col(0).normalized();
  for (const double off : {-0.3, 0.0, 0.3}) {
    std::vector<ControlPair> pairs;
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(100, 200), {600, 250}}) {
      pairs.push_back({point, truth(point) + off * along});
    }
    const auto alignment = prior::AlignByPairs(plan, evidence, pairs, {});
    ASSERT_TRUE(alignment.ok()) << alignment.status();
    EXPECT_THAT(alignment->reason, testing::HasSubstr("the walls are parallel"));
    EXPECT_THAT(alignment->reason, testing::HasSubstr("0.1 times as large as its file says"));
    const Eigen::Vector2d middle(350, 225);
    const Eigen::Vector2d error = alignment->T_map_sheet(middle) - truth(middle);
    EXPECT_NEAR(error.dot(along), off, 0.1) << "where the clicks put it";
    EXPECT_LT(std::abs(error.dot(truth.linear.col(1).normalized())), 0.05);
  }
  EXPECT_FALSE(prior::AlignByItself(plan, evidence, {}).accepted);
}

// On a line of half a metre's breadth: nothing says from the pairs alone whether the plan is mirrored.
TEST(AlignByPairsTest, PairsOnOneLineAreEnoughIfTheWallsDecide) {
  const PlanGraph plan = DrawnBuilding();
  for (const bool mirrored : {false, true}) {
    const PlanTransform truth = Turned(0.7, 0.05, mirrored);
    const MapEvidence evidence = EvidenceOf(MapOf(plan, truth, IsLeft));
    std::vector<ControlPair> pairs;
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 200), {160, 205}, {320, 196}, {520, 204}}) {
      pairs.push_back({point, truth(point)});
    }
    const auto alignment = prior::AlignByPairs(plan, evidence, pairs, {});
    ASSERT_TRUE(alignment.ok()) << alignment.status();
    EXPECT_EQ(alignment->T_map_sheet.mirrored(), mirrored);
    EXPECT_LT(LargestError(plan, alignment->T_map_sheet, truth), 0.2);
    EXPECT_THAT(alignment->reason, testing::Not(testing::HasSubstr("parallel")));
  }
}

TEST(FitPairsTest, TheWrongOneOfFiveIsNamedAndLeftOut) {
  const PlanTransform truth = Turned(0.7, 0.05, false);
  std::vector<ControlPair> pairs;
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), {800, 20}, {30, 400}, {500, 210}, {300, 90}}) {
    pairs.push_back({point, truth(point)});
  }
  pairs[3].point_map += Eigen::Vector2d(2.5, 1.0);
  const auto fit = FitPairs(pairs, 1000);
  ASSERT_TRUE(fit.ok());
  ASSERT_TRUE(fit->wrong.has_value());
  EXPECT_EQ(*fit->wrong, 3U);
  EXPECT_NEAR(fit->residuals[3], std::hypot(2.5, 1.0), 1e-6);
  EXPECT_NEAR(fit->T_map_sheet.scale(), 0.05, 1e-9);
}

TEST(FitPairsTest, PairsThatMakeAPlanLargerThanAnyBuildingAreRefused) {
  for (const double far : {1e6, 1e150, 1e300}) {
    const auto fit = FitPairs({{{0, 0}, {0, 0}}, {{1000, 0}, {far, 0}}}, 1000);
    EXPECT_EQ(fit.status().code(), absl::StatusCode::kInvalidArgument) << far;
  }
  EXPECT_TRUE(FitPairs({{{0, 0}, {0, 0}}, {{1000, 0}, {1000, 0}}}, 1000).ok());
}

TEST(FitPairsTest, AMirroredPlanIsRecognised) {
  const PlanTransform truth = Turned(0.7, 0.05, true);
  std::vector<ControlPair> pairs;
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), {800, 20}, {30, 400}})
    pairs.push_back({point, truth(point)});
  const auto fit = FitPairs(pairs, 1000);
  ASSERT_TRUE(fit.ok());
  EXPECT_TRUE(fit->T_map_sheet.mirrored());
}

TEST(FitPairsTest, EachAxisHasItsScaleFromFourPairsOn) {
  PlanTransform truth = Turned(0.7, 0.05, false);
  truth.linear.col(1) *= 1.2;
  std::vector<ControlPair> pairs;
  for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), {800, 20}, {30, 400}, {700, 390}})
    pairs.push_back({point, truth(point)});
  const auto fit = FitPairs(pairs, 1000);
  ASSERT_TRUE(fit.ok());
  EXPECT_EQ(fit->model, TransformModel::kAnisotropic);
  EXPECT_LT((fit->T_map_sheet.linear - truth.linear).norm(), 1e-6);
}

TEST(FitPairsTest, PairsThatDetermineNothingAreRefused) {
  const auto message = [](const std::vector<ControlPair>& pairs) {
    return std::string(FitPairs(pairs, 1000).status().message());
  };
  EXPECT_THAT(message({{{0, 0}, {0, 0}}}), testing::HasSubstr("1 pairs of points, at least 2"));
  EXPECT_THAT(message({{{0, 0}, {0, 0}}, {{0, 0}, {9, 0}}}), testing::HasSubstr("pairs 1 and 2 show the same point"));
  EXPECT_THAT(message({{{0, 0}, {0, 0}}, {{20, 0}, {1, 0}}}), testing::HasSubstr("at most 1.0 m"));
  EXPECT_THAT(message(std::vector<ControlPair>(1001)), testing::HasSubstr("1001 pairs of points, at most 1000"));
  EXPECT_THAT(message({{{0, 0}, {0, 0}}, {{20, 0}, {std::nan(""), 0}}}), testing::HasSubstr("pair 2"));
}

// A plan whose right part is drawn 4 % too long, and in which one wall has been shifted by 0.3 m.
TEST(CorrectedPlanTest, WallsMoveOntoTheMapsAndUnseenOnesFollow) {
  const PlanGraph plan = DrawnBuilding();
  const PlanTransform drawn = Turned(0.3, 0.05, false);
  const Placement built = [&](const Eigen::Vector2d& p) {
    Eigen::Vector2d moved = p;
    if (p.x() > 240) moved.x() = 240 + (p.x() - 240) * 0.96;
    if (p.x() == 320 && p.y() <= 200) moved.x() += 6;  // 0.3 m
    return drawn(moved);
  };
  const MapEvidence evidence = EvidenceOf(MapOf(plan, built, IsLeft));
  const CorrectedPlan corrected(plan, evidence, drawn);
  double seen = 0;
  int count = 0;
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    for (const int corner : {plan.walls[i].from, plan.walls[i].to}) {
      const Eigen::Vector2d sheet = plan.corners[static_cast<std::size_t>(corner)].point;
      if (!IsLeft(sheet)) continue;
      seen += (corrected.corners()[static_cast<std::size_t>(corner)].point - built(sheet)).norm();
      ++count;
    }
  }
  EXPECT_LT(seen / count, 0.12);
  EXPECT_GT(corrected.agreement().explained, 0.95);
  // What no robot has seen: off by 1 m as drawn.
  const CorrectedPoint corner = corrected.Locate({880, 0});
  EXPECT_EQ(corner.sight, Sight::kUnseen);
  const double before = (drawn(Eigen::Vector2d(880, 0)) - built({880, 0})).norm();
  const double after = (corner.point - built({880, 0})).norm();
  EXPECT_GT(before, 1.0);
  EXPECT_LT(after, 0.6 * before);
  EXPECT_LT(after, 3 * corner.sigma);
}

}  // namespace
}  // namespace enfilade::prior
