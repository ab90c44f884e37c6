// SPDX-License-Identifier: Apache-2.0
#include "core/doors/driven_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace enfilade::doors {
namespace {

sensor::LaserScan ScanAt(TimeNs time) {
  sensor::LaserScan scan;
  scan.time = time;
  scan.angle_increment = 0.1;
  scan.range_max = 10.0F;
  scan.ranges = {1.0F, 2.0F, 3.0F};
  return scan;
}

// East in steps of `step`; the scans' times count the points.
DrivenPath Drive(double length, int points, double step) {
  DrivenPath path(length);
  for (int i = 0; i < points; ++i) path.Add(ScanAt(i), {i * step, 0, 0});
  return path;
}

TEST(DrivenPath, MeasuresTheDistanceTravelled) {
  DrivenPath path(100.0);
  EXPECT_TRUE(path.empty());
  path.Add(ScanAt(0), {5, 5, 0});
  path.Add(ScanAt(1), {8, 9, 0});
  path.Add(ScanAt(2), {8, 8, 0});
  EXPECT_FALSE(path.empty());
  EXPECT_DOUBLE_EQ(path.travelled(), 6.0) << "along the path, not as the crow flies";
  EXPECT_DOUBLE_EQ(path.oldest_travelled(), 0.0);
  EXPECT_EQ(path.view().time, 2);
}

TEST(DrivenPath, InterpolatesPositions) {
  const DrivenPath path = Drive(100.0, 5, 0.5);
  for (const double travelled : {0.0, 0.25, 0.5, 1.1, 2.0}) {
    EXPECT_NEAR(path.PositionAt(travelled).x(), travelled, 1e-12);
    EXPECT_NEAR(path.PositionAt(travelled).y(), 0.0, 1e-12);
  }
  EXPECT_NEAR(path.PositionAt(-1.0).x(), 0.0, 1e-12) << "its ends are its limits";
  EXPECT_NEAR(path.PositionAt(9.0).x(), 2.0, 1e-12);
}

TEST(DrivenPath, FindsTheFirstViewThatIsNotBeforeAPlace) {
  const DrivenPath path = Drive(100.0, 5, 0.5);
  EXPECT_EQ(path.ViewAt(0.0).time, 0);
  EXPECT_EQ(path.ViewAt(0.5).time, 1);
  EXPECT_EQ(path.ViewAt(0.6).time, 2);
  EXPECT_EQ(path.ViewAt(7.0).time, 4);
  EXPECT_EQ(path.ViewAt(-7.0).time, 0);
}

TEST(DrivenPath, ARobotThatStandsStillKeepsItsLastViewOnly) {
  DrivenPath path(100.0);
  path.Add(ScanAt(0), {0, 0, 0});
  path.Add(ScanAt(1), {1, 0, 0});
  for (int i = 2; i < 50; ++i) path.Add(ScanAt(i), {1, 0, 0.1 * i});
  EXPECT_DOUBLE_EQ(path.travelled(), 1.0);
  EXPECT_EQ(path.view().time, 49);
  EXPECT_EQ(path.ViewAt(1.0).time, 1) << "where it arrived is kept, too";
}

TEST(DrivenPath, CreepingAddsUp) {
  const DrivenPath path = Drive(100.0, 101, 0.01);
  EXPECT_NEAR(path.travelled(), 1.0, 1e-9);
  EXPECT_NEAR(path.PositionAt(0.5).x(), 0.5, 1e-9);
}

TEST(DrivenPath, ForgetsWhatIsFartherBackThanItsLength) {
  const DrivenPath path = Drive(3.0, 100, 0.1);
  EXPECT_NEAR(path.travelled(), 9.9, 1e-9);
  EXPECT_GE(path.travelled() - path.oldest_travelled(), 3.0) << "at least its length is kept";
  EXPECT_LE(path.travelled() - path.oldest_travelled(), 3.2);
  EXPECT_NEAR(path.PositionAt(8.0).x(), 8.0, 1e-9);
}

TEST(DrivenPath, TheLastStepLeadsFromThePointBefore) {
  DrivenPath path(100.0);
  path.Add(ScanAt(0), {2, 3, 0});
  EXPECT_EQ(path.LastStep().from, path.LastStep().to);
  path.Add(ScanAt(1), {2, 5, 0});
  const DrivenPath::Step step = path.LastStep();
  EXPECT_EQ(step.from, Eigen::Vector2d(2, 3));
  EXPECT_EQ(step.to, Eigen::Vector2d(2, 5));
  EXPECT_DOUBLE_EQ(step.middle, 1.0);
}

TEST(DrivenPath, ContinuesFromItsState) {
  DrivenPath path = Drive(3.0, 40, 0.13);
  std::string bytes;
  BinaryWriter writer(bytes);
  path.Write(writer);
  DrivenPath again(3.0);
  BinaryReader reader(bytes);
  again.Read(reader);
  ASSERT_TRUE(reader.ok() && reader.at_end());
  for (DrivenPath* one : {&path, &again}) one->Add(ScanAt(99), {5.5, 0.3, 0.1});
  EXPECT_EQ(again.travelled(), path.travelled());
  EXPECT_EQ(again.oldest_travelled(), path.oldest_travelled());
  for (double travelled = 2.0; travelled < 6.0; travelled += 0.1) {
    EXPECT_EQ(again.PositionAt(travelled), path.PositionAt(travelled));
    EXPECT_EQ(again.ViewAt(travelled).time, path.ViewAt(travelled).time);
  }
}

TEST(DrivenPath, ATruncatedStateEndsTheReader) {
  const DrivenPath path = Drive(3.0, 10, 0.3);
  std::string bytes;
  BinaryWriter writer(bytes);
  path.Write(writer);
  const std::string_view whole = bytes;
  for (const std::size_t size : {std::size_t{3}, whole.size() / 2, whole.size() - 1}) {
    DrivenPath again(3.0);
    BinaryReader reader(whole.substr(0, size));
    again.Read(reader);
    EXPECT_FALSE(reader.ok()) << size;
  }
}

}  // namespace
}  // namespace enfilade::doors
