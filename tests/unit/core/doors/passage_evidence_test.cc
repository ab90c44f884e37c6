// SPDX-License-Identifier: Apache-2.0
#include "core/doors/passage_evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace enfilade::doors {
namespace {

using ::testing::HasSubstr;
using State = CriterionVerdict::State;

PassageEvidence ADoor() {
  PassageEvidence evidence;
  evidence.ahead.state = State::kMet;
  evidence.behind.state = State::kMet;
  evidence.environment.state = State::kMet;
  evidence.hidden = 0.6;
  evidence.walls.left = 1.0;
  evidence.walls.right = 0.9;
  evidence.parallel = 0.2;
  return evidence;
}

TEST(JudgePassage, TakesAGapInAWall) {
  const PassageVerdict verdict = JudgePassage(ADoor(), {});
  EXPECT_TRUE(verdict.passage);
  EXPECT_THAT(verdict.reason, HasSubstr("3 of three criteria; its wall runs on for 1.00 and 0.90 m"));
}

TEST(JudgePassage, NeedsTheCriterionBehindAndOneMore) {
  PassageEvidence evidence = ADoor();
  evidence.behind.state = State::kOpen;
  EXPECT_FALSE(JudgePassage(evidence, {}).passage);
  evidence = ADoor();
  evidence.ahead.state = State::kOpen;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage);
  evidence.environment.state = State::kDropped;
  EXPECT_FALSE(JudgePassage(evidence, {}).passage);
}

TEST(JudgePassage, NeedsAWall) {
  PassageEvidence evidence = ADoor();
  evidence.walls.right = 0.3;
  EXPECT_THAT(JudgePassage(evidence, {}).reason, HasSubstr("no gap in a wall"));
  evidence.walls.right_again = 0.7;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage) << "a pane beside it";
  evidence.walls.left = 0.1;
  evidence.walls.left_again = 2.0;
  EXPECT_FALSE(JudgePassage(evidence, {}).passage) << "posts that stand alone";
}

TEST(JudgePassage, TakesAWallAcrossACorridorFromCornerToCorner) {
  PassageEvidence evidence = ADoor();
  evidence.walls.left = evidence.walls.right = 0.3;
  evidence.walls.left_cornered = true;
  EXPECT_FALSE(JudgePassage(evidence, {}).passage);
  evidence.walls.right_cornered = true;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage);
  evidence.walls.left = evidence.walls.right = 0.55;
  evidence.environment.state = State::kOpen;
  evidence.hidden = 0.05;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage) << "down the corridor most stays in sight through the door";
}

TEST(JudgePassage, TakesFurnitureForNoWall) {
  PassageEvidence evidence = ADoor();
  evidence.parallel = 0.42;
  EXPECT_THAT(JudgePassage(evidence, {}).reason, HasSubstr("1.90 m long, 4.5 times its depth along the way"));
  evidence.walls.left_again = 0.5;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage) << "half of what continues behind an interruption counts";
  evidence.walls.left_again = 0.0;
  DoorOptions options;
  options.gap.slender = 4.0;
  EXPECT_TRUE(JudgePassage(evidence, options).passage);
}

TEST(JudgePassage, TakesACupboardInACorridorForNoWallAcrossIt) {
  PassageEvidence evidence = ADoor();
  evidence.walls.left = 0.4;
  evidence.walls.right = 0.1;
  evidence.walls.left_cornered = evidence.walls.right_cornered = true;
  evidence.parallel = 0.3;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage) << "it hides the ground behind it";
  evidence.environment.state = State::kOpen;
  evidence.hidden = 0.25;
  EXPECT_THAT(JudgePassage(evidence, {}).reason, HasSubstr("1.7 times its depth"));
}

TEST(JudgePassage, NeedsTheWallEvenIfTheScannerLooksAheadOnly) {
  PassageEvidence evidence = ADoor();
  evidence.environment.state = State::kDropped;
  evidence.hidden = -1.0;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage);
  evidence.walls.left = evidence.walls.right = 0.2;
  EXPECT_THAT(JudgePassage(evidence, {}).reason, HasSubstr("no gap in a wall"));
}

TEST(JudgePassage, RefusesWallsBesideTheWay) {
  PassageEvidence evidence = ADoor();
  evidence.parallel = 0.8;
  EXPECT_THAT(JudgePassage(evidence, {}).reason, HasSubstr("beside the way for 0.80 m"));
}

TEST(JudgePassage, ALongWallOutweighsGroundInSightAndAWayRound) {
  PassageEvidence evidence = ADoor();
  evidence.environment.state = State::kOpen;
  evidence.hidden = 0.05;
  EXPECT_THAT(JudgePassage(evidence, {}).reason, HasSubstr("5 % of the ground"));
  evidence.walls.left = 2.0;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage);
  evidence.way_round = true;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage) << "14 times as long as deep";
  evidence.parallel = 0.35;
  EXPECT_THAT(JudgePassage(evidence, {}).reason, HasSubstr("leads round"));
  evidence.environment.state = State::kMet;
  EXPECT_TRUE(JudgePassage(evidence, {}).passage);
}

}  // namespace
}  // namespace enfilade::doors
