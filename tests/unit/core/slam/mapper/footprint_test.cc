// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/slam/mapper/mapper.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

// The bounds that docs/slam.md states, bytes.
constexpr std::size_t kPerKeyframe = 1'000;  // with its edges and the closures tried from it
constexpr std::size_t kPerSubmap = 100'000;  // of a finished one's content, compressed: indoors, a 180-degree scanner
constexpr std::size_t kWorking = 100'000'000;

std::vector<testing::Wall> Rooms() {
  return testing::WallsFromText({"##############################",  //
                                 "#    #       ##       #      #",  //
                                 "#                            #",  //
                                 "#   ###################      #",  //
                                 "#   #                 #     ##",  //
                                 "##  #                 ##     #",  //
                                 "#   ##                #      #",  //
                                 "#   #                 #   ####",  //
                                 "##  #                 ##     #",  //
                                 "#   ###################      #",  //
                                 "#                         #  #",  //
                                 "#    #      ##      #        #",  //
                                 "##############################"},
                                1.0);
}

std::vector<sensor::PairedScan> Rounds(int rounds) {
  std::vector<Eigen::Vector2d> corners;
  for (int i = 0; i < rounds; ++i) corners.insert(corners.end(), {{2.5, 1.5}, {24.5, 1.5}, {24.5, 10.5}, {2.5, 10.5}});
  corners.push_back({2.5, 1.5});
  return testing::Record(Rooms(), testing::Drive(corners, 0.25), {}, {0.02, 0.02}, 5);
}

TEST(Footprint, OfADriveGrowsByWhatItsKeyframesAndSubmapsMayCost) {
  const auto log = Rounds(6);
  Mapper mapper(SlamOptions{});
  std::size_t nodes = 0;
  std::size_t submaps = 0;
  std::size_t first_round = 0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    nodes += mapper.AddScan(log[i]).keyframe;
    for (const SlamSubmap& submap : mapper.TakeDelta().submaps) {
      submaps = std::max(submaps, static_cast<std::size_t>(submap.id) + 1);
    }
    const Footprint footprint = mapper.footprint();
    ASSERT_LT(footprint.working, kWorking) << "at scan " << i;
    ASSERT_LT(footprint.kept, nodes * kPerKeyframe + submaps * kPerSubmap) << "at scan " << i;
    if (i == log.size() / 6) first_round = footprint.kept;
  }
  EXPECT_GT(submaps, 5U);
  EXPECT_GT(first_round, 0U);
  EXPECT_LT(mapper.footprint().kept, 8 * first_round) << "in proportion to the distance";
}

// The raster grows with the area, not with the distance.
TEST(Footprint, OfTheRasterStaysInAPlaceDrivenAgain) {
  Mapper once(SlamOptions{});
  for (const sensor::PairedScan& scan : Rounds(2)) once.AddScan(scan);
  once.RenderGrid();
  Mapper often(SlamOptions{});
  for (const sensor::PairedScan& scan : Rounds(6)) often.AddScan(scan);
  often.RenderGrid();
  EXPECT_GT(once.footprint().raster, 0U);
  EXPECT_LE(often.footprint().raster, 2 * once.footprint().raster) << "after three times the distance";
}

TEST(Footprint, DoesNotGrowWhereTheRobotStands) {
  const std::vector<Pose2> still(400, Pose2{2.5, 1.5, 0.3});
  const auto log = testing::Record(Rooms(), still, {}, {}, 2);
  Mapper mapper(SlamOptions{});
  std::size_t early = 0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    mapper.AddScan(log[i]);
    if (i == 10) early = mapper.footprint().total();
  }
  EXPECT_EQ(mapper.footprint().total(), early);
}

TEST(Footprint, IsTheSameAfterRestore) {
  Mapper mapper(SlamOptions{});
  for (const sensor::PairedScan& scan : Rounds(2)) mapper.AddScan(scan);
  SlamMap map;
  map.Apply(mapper.TakeDelta());
  auto restored = Mapper::Restore({}, map, mapper.Checkpoint());
  ASSERT_TRUE(restored.ok());
  const auto held = static_cast<double>(mapper.footprint().kept);
  EXPECT_NEAR(static_cast<double>(restored->footprint().kept), held, 0.05 * held);
}

}  // namespace
}  // namespace enfilade::slam
