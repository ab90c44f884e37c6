// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/passage_silence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/rooms/room_partition.h"
#include "tests/unit/core/rooms/drawn_rooms.h"

namespace enfilade::rooms {
namespace {

// Two doors that look alike. A robot drives back and forth through both.
const DrawnRooms& TwoDoors() {
  static const DrawnRooms drawn({
      "###############################",
      "#         #         #         #",
      "#         #         #         #",
      "#         #         #         #",
      "#                             #",
      "#    a    1    b    2    c    #",
      "#                             #",
      "#                             #",
      "#         #         #         #",
      "#         #         #         #",
      "#         #         #         #",
      "###############################",
  });
  return drawn;
}

PassageHint ReportAt(const DrawnRooms& drawn, char door) {
  return {drawn[door] + Eigen::Vector2d(0.0, 0.5), drawn[door] - Eigen::Vector2d(0.0, 0.5)};
}

std::vector<DoorLine> JudgeAll(const DrawnRooms& drawn, const std::string& reports,
                               const std::vector<Eigen::Vector2d>& trajectory) {
  std::vector<PassageHint> passages;
  for (const char door : reports) passages.push_back(ReportAt(drawn, door));
  const GroundMap ground = ReadGround(drawn.grid, {}, trajectory);
  const RoomEvidence evidence{passages, trajectory};
  const DoorOdds odds(evidence);
  std::vector<DoorLine> lines = FindDoorLines(ground, DistancesToWalls(ground), {}, odds);
  AddPassages(ground, drawn.grid.geometry, passages, RoomOptions(), odds, lines);
  WeighSilence(drawn.grid.geometry, evidence, odds, lines);
  return lines;
}

// The lines at the doors 1 and 2, as judged by these reports and that way.
std::pair<DoorLine, DoorLine> Judge(const DrawnRooms& drawn, const std::string& reports, const std::string& way) {
  const std::vector<DoorLine> lines = JudgeAll(drawn, reports, drawn.Path(way));
  const auto at = [&](char door) {
    const Eigen::Vector2d cells = ToCells(drawn.grid.geometry, drawn[door]);
    for (const DoorLine& line : lines) {
      if (std::abs(line.line.middle().x() - cells.x()) < 3.0) return line;
    }
    ADD_FAILURE() << "no line at door " << door;
    return DoorLine{};
  };
  return {at('1'), at('2')};
}

TEST(PassageSilence, ALineThatIsPassedWithoutReportsIsLessOfADoor) {
  const auto [reported, silent] = Judge(TwoDoors(), "111111", "abcbabcbabcba");
  EXPECT_EQ(reported.evidence.reports, 6);
  EXPECT_EQ(reported.evidence.silence, 0.0);
  EXPECT_GT(silent.evidence.silence, 2.0);
  EXPECT_GT(silent.openness, reported.openness);
}

TEST(PassageSilence, EachPassageCounts) {
  const double twice = Judge(TwoDoors(), "11", "abcba").second.evidence.silence;
  const double four_times = Judge(TwoDoors(), "1111", "abcbabcba").second.evidence.silence;
  EXPECT_GT(twice, 0.5);
  EXPECT_GT(four_times, 1.5 * twice);
}

TEST(PassageSilence, WithoutReportsNothingIsKnown) {
  const auto [one, other] = Judge(TwoDoors(), "", "abcbabcba");
  EXPECT_EQ(one.evidence.silence, 0.0);
  EXPECT_EQ(other.evidence.silence, 0.0);
}

TEST(PassageSilence, AnUnsteadyDetectorSaysLess) {
  const double steady = Judge(TwoDoors(), "1111", "abcbabcba").second.evidence.silence;
  const double unsteady = Judge(TwoDoors(), "1", "abcbabcba").second.evidence.silence;
  EXPECT_GT(unsteady, 0.0);
  EXPECT_LT(unsteady, 0.5 * steady);
}

TEST(PassageSilence, AJumpIsNoPassage) {
  const std::vector<DoorLine> lines = JudgeAll(TwoDoors(), "1", {TwoDoors()['a'], TwoDoors()['c'], TwoDoors()['a']});
  ASSERT_EQ(lines.size(), 2U);
  for (const DoorLine& line : lines) EXPECT_EQ(line.evidence.silence, 0.0);
}

TEST(PassageSilence, WiderLinesThanAnyThatIsReportedAreNotJudgedByIt) {
  const DrawnRooms drawn({
      "###############################",
      "#         #         #         #",
      "#         #                   #",
      "#         #                   #",
      "#                             #",
      "#    a    1    b    2    c    #",
      "#                             #",
      "#                             #",
      "#         #                   #",
      "#         #                   #",
      "#         #         #         #",
      "###############################",
  });
  EXPECT_EQ(Judge(drawn, "1111", "abcbabcba").second.evidence.silence, 0.0);
}

TEST(WidestReported, IsALittleWiderThanTheWidestPassage) {
  const std::vector<PassageHint> passages = {{{0.0, 0.0}, {0.9, 0.0}}, {{3.0, 1.0}, {3.0, 2.4}}};
  EXPECT_NEAR(WidestReported(passages), 1.6, 1e-9);
  EXPECT_EQ(WidestReported({}), 0.0);
}

}  // namespace
}  // namespace enfilade::rooms
