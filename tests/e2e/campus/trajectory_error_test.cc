// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/trajectory_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

// A curve of 20 s, seen from another frame.
std::vector<TimedPose> Curve(const Pose2& T_frame_curve, double step = 0.5) {
  std::vector<TimedPose> curve;
  for (double t = 100.0; t <= 120.0; t += step) {
    const double angle = 0.2 * (t - 100.0);
    curve.push_back({t, T_frame_curve * Pose2{std::cos(angle), std::sin(angle), angle + M_PI / 2.0}});
  }
  return curve;
}

TEST(ErrorByReference, DoesNotDependOnTheFrame) {
  const TrajectoryError error = ErrorByReference(Curve({3.0, -2.0, 2.5}), Curve({}));
  EXPECT_EQ(error.used, 41);
  EXPECT_NEAR(error.metres, 0.0, 1e-9);
  EXPECT_NEAR(error.degrees, 0.0, 1e-9);
}

TEST(ErrorByReference, IsTheRootMeanSquareAndCountsWhatIsMissing) {
  std::vector<TimedPose> off = Curve({});
  for (std::size_t i = 0; i < off.size(); ++i) off[i].pose.x += i % 2 == 0 ? 0.1 : -0.1;
  off.resize(21);  // up to 110 s
  const TrajectoryError error = ErrorByReference(off, Curve({}));
  EXPECT_EQ(error.used, 22) << "half a second is near enough";
  EXPECT_EQ(error.skipped, 19);
  EXPECT_NEAR(error.metres, 0.1, 0.02);
}

TEST(ErrorByRelations, ComparesMotionsBetweenTwoTimes) {
  const std::vector<TimedPose> curve = Curve({1.0, 1.0, 1.0});
  const Pose2 right = Between(curve[4].pose, curve[24].pose);
  const Pose2 off{right.x + 0.3, right.y, right.yaw};
  const TrajectoryError error =
      ErrorByRelations(curve, {{curve[4].time, curve[24].time, right}, {102.0, 112.0, off}, {102.0, 500.0, {}}});
  EXPECT_EQ(error.used, 2);
  EXPECT_EQ(error.skipped, 1);
  EXPECT_NEAR(error.metres, 0.15, 1e-9);
  EXPECT_NEAR(error.degrees, 0.0, 1e-9);
}

TEST(ErrorByRelations, InterpolatesBetweenPoses) {
  const TrajectoryError error =
      ErrorByRelations(Curve({}, 0.8), {{100.4, 115.6, Between(Curve({}, 0.4)[1].pose, Curve({}, 0.4)[39].pose)}});
  EXPECT_EQ(error.used, 1);
  EXPECT_LT(error.metres, 0.01);
}

TEST(ReadTrajectory, SkipsWhatIsNoPose) {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "t.csv";
  std::ofstream(file) << "t,x,y,yaw\n# comment\n2,1,0,0\n1.5 0 0 0.25\n";
  const std::vector<TimedPose> read = ReadTrajectory(file);
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].time, 1.5);
  EXPECT_EQ(read[0].pose.yaw, 0.25);
  EXPECT_THROW(ReadTrajectory(directory.path() / "none"), std::runtime_error);
}

}  // namespace
}  // namespace enfilade::testing
