// SPDX-License-Identifier: Apache-2.0
#include "core/closure/judge_place.h"

#include "gmock/gmock.h"

namespace enfilade::closure {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

PoseWithCovariance Pose(double x, double y, double sigma = 0.1) {
  return {{x, y, 0}, Eigen::Vector3d(sigma * sigma, sigma * sigma, 0.0025).asDiagonal()};
}

PlaceEvidence Unseen(const std::string& id, const std::string& map = "old") {
  PlaceEvidence evidence;
  evidence.link_point = LinkPointId(id);
  evidence.map = MapId(map);
  return evidence;
}

// The best evidence for a place: the robot is at (x, 0).
PlaceEvidence Clear(const std::string& id, double x = 1.0, const std::string& map = "old") {
  PlaceEvidence evidence = Unseen(id, map);
  evidence.images = ImageComparison{60, true};
  evidence.clouds = CloudComparison{0.05, 0.9, true, Pose(x, 0, 0.05)};
  evidence.predicted = Pose(x + 0.1, 0);
  return evidence;
}

TEST(JudgePlace, AcceptsIfImagesCloudsAndGraphAgree) {
  const JudgedPlace judged = JudgePlace(Clear("a"), {});
  EXPECT_TRUE(judged.accepted) << judged.reason;
  EXPECT_EQ(judged.T_map_robot.pose.x, 1.0);
  ASSERT_TRUE(judged.chi2.has_value());
  EXPECT_LT(*judged.chi2, 1.0);
}

TEST(JudgePlace, RefusesIfTheGraphHasTheRobotElsewhere) {
  PlaceEvidence evidence = Clear("a");
  evidence.predicted = Pose(6, 0);
  const JudgedPlace judged = JudgePlace(evidence, {});
  EXPECT_FALSE(judged.accepted);
  EXPECT_THAT(judged.reason, HasSubstr("the graph has the robot elsewhere"));
  evidence.predicted = Pose(6, 0, 5.0);  // it may well be here: a long way round
  EXPECT_TRUE(JudgePlace(evidence, {}).accepted);
}

TEST(JudgePlace, WithoutAPredictionBothMustAgreeMoreClosely) {
  PlaceEvidence evidence = Clear("a");
  evidence.predicted.reset();
  EXPECT_TRUE(JudgePlace(evidence, {}).accepted);
  EXPECT_FALSE(JudgePlace(evidence, {}).chi2.has_value());
  evidence.clouds->inlier_share = 0.55;
  EXPECT_FALSE(JudgePlace(evidence, {}).accepted);
  evidence.clouds->inlier_share = 0.95;
  evidence.images->matches = 25;
  EXPECT_FALSE(JudgePlace(evidence, {}).accepted);
  evidence.images.reset();
  EXPECT_THAT(JudgePlace(evidence, {}).reason, HasSubstr("clouds alone do not suffice"));
  evidence.images = ImageComparison{3, false};
  EXPECT_FALSE(JudgePlace(evidence, {}).accepted);
}

TEST(JudgePlace, WithoutImagesTheCloudsMustBeStrictAndTheGraphSure) {
  PlaceEvidence evidence = Clear("a");
  evidence.images.reset();
  EXPECT_TRUE(JudgePlace(evidence, {}).accepted);
  evidence.clouds->inlier_share = 0.7;
  EXPECT_THAT(JudgePlace(evidence, {}).reason, HasSubstr("not alike enough"));
  evidence.clouds->inlier_share = 0.9;
  evidence.predicted = Pose(1, 0, 2.0);
  EXPECT_THAT(JudgePlace(evidence, {}).reason, HasSubstr("not sure enough"));
  evidence.predicted = Pose(1.6, 0, 0.1);
  EXPECT_THAT(JudgePlace(evidence, {}).reason, HasSubstr("not near enough"));
}

TEST(JudgePlace, WithoutCloudsTheGraphGivesThePoseIfItIsSure) {
  PlaceEvidence evidence = Clear("a");
  evidence.clouds.reset();
  const JudgedPlace judged = JudgePlace(evidence, {});
  EXPECT_TRUE(judged.accepted);
  EXPECT_EQ(judged.T_map_robot.pose, evidence.predicted->pose);
  evidence.predicted = Pose(1, 0, 2.0);
  EXPECT_FALSE(JudgePlace(evidence, {}).accepted);
  evidence.predicted.reset();
  EXPECT_THAT(JudgePlace(evidence, {}).reason, HasSubstr("images alone give no pose"));
}

TEST(JudgePlace, TellsImagesOfTheSameViewFromAnotherPlace) {
  PlaceEvidence evidence = Clear("a");
  evidence.images = ImageComparison{.matches = 0, .agree = false, .other_place = true};
  evidence.clouds.reset();
  const JudgedPlace judged = JudgePlace(evidence, {});
  EXPECT_FALSE(judged.accepted);
  EXPECT_THAT(judged.reason, HasSubstr("same view, other place"));
}

TEST(JudgePlace, RefusesCloudsThatAreNotOfOnePlaceWhateverTheImages) {
  PlaceEvidence evidence = Clear("a");
  evidence.clouds->agree = false;
  EXPECT_THAT(JudgePlace(evidence, {}).reason, HasSubstr("the clouds are not of one place"));
}

TEST(JudgePlace, SaysWhatWasMissing) {
  PlaceEvidence evidence = Unseen("a");
  evidence.missing = "no cloud is kept of the place";
  const JudgedPlace judged = JudgePlace(evidence, {});
  EXPECT_FALSE(judged.accepted);
  EXPECT_THAT(judged.reason, HasSubstr("nothing to compare"));
  EXPECT_THAT(judged.reason, HasSubstr("no cloud is kept"));
  evidence.images = ImageComparison{2, false};
  EXPECT_THAT(JudgePlace(evidence, {}).reason, HasSubstr("the images are not of one place"));
}

TEST(Contradicted, OnlyIfImagesAndCloudsBothSpeakAgainstIt) {
  PlaceEvidence evidence = Unseen("a");
  EXPECT_FALSE(IsContradicted(evidence, {}));
  evidence.images = ImageComparison{2, false};
  EXPECT_FALSE(IsContradicted(evidence, {}));
  evidence.clouds = CloudComparison{1.0, 0.2, false, {}};
  EXPECT_TRUE(IsContradicted(evidence, {}));
  evidence.clouds->inlier_share = 0.6;  // furniture has been moved
  EXPECT_FALSE(IsContradicted(evidence, {}));
  evidence.clouds->inlier_share = 0.2;
  evidence.images->agree = true;
  EXPECT_FALSE(IsContradicted(evidence, {}));
}

TEST(ChoosePlace, ChoosesNoneIfNoneIsAccepted) {
  EXPECT_FALSE(ChoosePlace({}, {}).chosen.has_value());
  const PassageChoice choice = ChoosePlace({Unseen("a"), Unseen("b")}, {});
  EXPECT_FALSE(choice.chosen.has_value());
  EXPECT_THAT(choice.reason, HasSubstr("none of 2"));
}

// The index into the compared places is not a link point's id.
TEST(ChoosePlace, IdentifiesTheChosenPlaceByItsOwnId) {
  const std::vector<PlaceEvidence> evidence = {Unseen("place-7"), Clear("place-3"), Unseen("place-9")};
  const PassageChoice choice = ChoosePlace(evidence, {});
  ASSERT_TRUE(choice.chosen.has_value());
  EXPECT_EQ(evidence[*choice.chosen].link_point, LinkPointId("place-3"));
  EXPECT_THAT(choice.order, ElementsAre(1, 0, 2));
}

TEST(ChoosePlace, TheOrderOfThePlacesDoesNotMatter) {
  const PlaceEvidence right = Clear("right"), wrong = Unseen("wrong");
  EXPECT_EQ(*ChoosePlace({right, wrong}, {}).chosen, 0U);
  EXPECT_EQ(*ChoosePlace({wrong, right}, {}).chosen, 1U);
}

TEST(ChoosePlace, ChoosesNeitherOfTwoThatLookAlike) {
  const PassageChoice choice = ChoosePlace({Clear("a", 1.0, "one"), Clear("b", 1.0, "other")}, {});
  EXPECT_FALSE(choice.chosen.has_value());
  EXPECT_THAT(choice.reason, HasSubstr("look alike"));
  // Nor of two in one map that put the robot at different places.
  EXPECT_FALSE(ChoosePlace({Clear("a", 1.0), Clear("b", 6.0)}, {}).chosen.has_value());
}

TEST(ChoosePlace, TheGraphTellsLookAlikesApart) {
  PlaceEvidence off = Clear("a", 1.0, "one");
  off.predicted = Pose(1.6, 0, 0.1);  // let through by the gate, but only just
  const std::vector<PlaceEvidence> evidence = {off, Clear("b", 1.0, "other")};
  const PassageChoice choice = ChoosePlace(evidence, {});
  ASSERT_TRUE(choice.judged[0].accepted) << choice.judged[0].reason;
  ASSERT_TRUE(choice.chosen.has_value());
  EXPECT_EQ(*choice.chosen, 1U);
  // One that the graph knows of against one that it does not.
  PlaceEvidence unknown = Clear("c", 1.0, "third");
  unknown.predicted.reset();
  EXPECT_EQ(*ChoosePlace({unknown, Clear("b", 1.0, "other")}, {}).chosen, 1U);
}

TEST(ChoosePlace, ImagesTellThemApartIfTheyDifferClearly) {
  PlaceEvidence faint = Clear("a", 1.0, "one");
  faint.images->matches = 20;
  EXPECT_EQ(*ChoosePlace({faint, Clear("b", 1.0, "other")}, {}).chosen, 1U);
}

TEST(ChoosePlace, TwoSightingsOfOneDoorDoNotExcludeEachOther) {
  PlaceEvidence second = Clear("b", 1.3);
  second.images->matches = 55;
  const PassageChoice choice = ChoosePlace({second, Clear("a", 1.0)}, {});
  ASSERT_TRUE(choice.chosen.has_value());
  EXPECT_EQ(*choice.chosen, 1U);  // the better of them
}

TEST(ToComparison, HasEverythingThatTheVerdictShows) {
  PlaceEvidence evidence = Clear("a");
  evidence.distance = 3.0;
  const DoorComparison comparison = ToComparison(evidence, JudgePlace(evidence, {}));
  EXPECT_EQ(comparison.link_point, LinkPointId("a"));
  EXPECT_EQ(comparison.distance, 3.0);
  EXPECT_EQ(comparison.image_matches, 60);
  EXPECT_TRUE(comparison.images_agree && comparison.clouds_agree && comparison.accepted);
  EXPECT_EQ(comparison.rmse, 0.05);
  EXPECT_TRUE(comparison.chi2.has_value());
  const DoorComparison empty = ToComparison(Unseen("b"), JudgePlace(Unseen("b"), {}));
  EXPECT_FALSE(empty.image_matches || empty.rmse || empty.chi2 || empty.distance || empty.accepted);
}

}  // namespace
}  // namespace enfilade::closure
