// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "client/cli/commands/commands.h"
#include "client/sources/formats/json_lines_writer.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/cli/command_test.h"

namespace enfilade::cli {
namespace {

using ::testing::HasSubstr;

constexpr double kHalfSide = 4.0;  // m, of a square room about the origin
constexpr TimeNs kStart = 1'700'000'000LL * kNsPerSecond;

// The distance from `p` to the room's walls or to the pillar in it, along `yaw`.
double RangeFrom(const Eigen::Vector2d& p, double yaw) {
  const Eigen::Vector2d along(std::cos(yaw), std::sin(yaw));
  double range = 1e9;
  for (const int axis : {0, 1}) {
    const double speed = along[axis];
    if (std::abs(speed) > 1e-9) range = std::min(range, ((speed > 0 ? kHalfSide : -kHalfSide) - p[axis]) / speed);
  }
  const Eigen::Vector2d to_pillar = Eigen::Vector2d(1.5, 2.0) - p;  // of 0.3 m radius
  const double middle = to_pillar.dot(along);
  const double aside2 = to_pillar.squaredNorm() - middle * middle;
  if (middle > 0.0 && aside2 < 0.09) range = std::min(range, middle - std::sqrt(0.09 - aside2));
  return range;
}

// A log of a robot that drives 2 m through the room, `scans` times a step further.
std::string Log(int scans, bool in_range = true) {
  std::string text = sources::JsonLinesHeader();
  for (int i = 0; i < scans; ++i) {
    const Pose2 pose{-1.0 + 0.2 * i, 0.1 * i, 0.05 * i};
    const TimeNs time = kStart + i * kNsPerSecond / 2;
    sensor::LaserScan scan;
    scan.time = time;
    scan.angle_min = -M_PI;
    scan.angle_increment = M_PI / 180.0;
    scan.range_min = 0.1;
    scan.range_max = in_range ? 20.0 : 0.5;
    for (int beam = 0; beam < 360; ++beam) {
      const double range = RangeFrom(pose.translation(), pose.yaw + scan.angle_min + beam * scan.angle_increment);
      scan.ranges.push_back(range < scan.range_max ? static_cast<float>(range) : INFINITY);
    }
    text += sources::ToJsonLine({sensor::Odometry{time, pose}, {}}).value();
    text += sources::ToJsonLine({scan, {}}).value();
  }
  return text;
}

class SlamTest : public CommandTest {
 protected:
  absl::Status Run(std::vector<std::string> arguments, bool json = true) {
    arguments.insert(arguments.begin(), "slam");
    return RunCommandLine(AddSlam, std::move(arguments), json);
  }

  nlohmann::json Report() const { return nlohmann::json::parse(printed_); }

  const std::filesystem::path out_ = directory_.path() / "out";
};

TEST_F(SlamTest, WritesTheTrajectoryTheMapAndTheClosures) {
  ASSERT_OK(Run({File("drive.jsonl", Log(11)), "-o", out_}));
  std::istringstream trajectory(Content(out_ / "trajectory.txt"));
  double t = 0.0, x = 0.0, y = 0.0, yaw = 0.0;
  int poses = 0;
  while (trajectory >> t >> x >> y >> yaw) {
    EXPECT_NEAR(t, 1.7e9 + 0.5 * poses, 1e-6) << "the recording's own absolute times";
    EXPECT_NEAR(x, 0.2 * poses, 0.03);
    EXPECT_NEAR(y, 0.1 * poses, 0.03);
    EXPECT_NEAR(yaw, 0.05 * poses, 0.02);
    ++poses;
  }
  EXPECT_EQ(poses, 11);
  EXPECT_TRUE(Content(out_ / "map.pgm").starts_with("P5"));
  EXPECT_THAT(Content(out_ / "map.yaml"), HasSubstr("image: map.pgm"));
  EXPECT_THAT(Content(out_ / "map.yaml"), HasSubstr("resolution: 0.05"));
  EXPECT_TRUE(Content(out_ / "map.png").starts_with("\x89PNG"));
  EXPECT_TRUE(nlohmann::json::parse(Content(out_ / "closures.json"))["closures"].is_array());
  EXPECT_FALSE(std::filesystem::exists(out_ / "plot.png"));
}

TEST_F(SlamTest, PrintsWhatProgramsAskFor) {
  ASSERT_OK(Run({File("drive.jsonl", Log(11))}));
  const nlohmann::json report = Report();
  EXPECT_EQ(report["scans"], 11);
  EXPECT_EQ(report["used"], 11);
  EXPECT_GT(report["keyframes"], 3);
  EXPECT_EQ(report["lost"], 0);
  EXPECT_EQ(report["without_odometry"], 0);
  EXPECT_EQ(report["dropped"], 0);
  EXPECT_EQ(report["submaps"], 1);
  EXPECT_EQ(report["closures_accepted"], 0);
  EXPECT_EQ(report["closures_rejected"], 0);
  EXPECT_GT(report["seconds"], 0.0);
  EXPECT_NEAR(report["scans_per_second"], 11.0 / report["seconds"].get<double>(), 1e-6);
  EXPECT_FALSE(std::filesystem::exists(out_)) << "nothing is written unasked";
}

// Four beams of two metres, whose directions the log does not tell.
TEST_F(SlamTest, TakesTheFieldOfViewThatTheLogDoesNotState) {
  const std::string log = File("beams.log", "FLASER 4 2 2 2 2 0 0 0 0 0 0 1700000000.5 host 0.5\n");
  const auto rows_of = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {log, "-o", out_});
    EXPECT_OK(Run(std::move(arguments)));
    std::istringstream pgm(Content(out_ / "map.pgm"));
    std::string magic;
    int columns = 0;
    int rows = 0;
    pgm >> magic >> columns >> rows;
    return rows;
  };
  EXPECT_NEAR(rows_of({}) * 0.05, 2.0 + std::sqrt(2.0), 0.2) << "from -90 to 45 degrees";
  EXPECT_NEAR(rows_of({"--fov", "90"}) * 0.05, 2.0 * (std::sin(M_PI / 4) + std::sin(M_PI / 8)), 0.2);
  EXPECT_FALSE(Run({log, "--fov", "-90"}).ok()) << "it would mirror the scan";
}

TEST_F(SlamTest, GoesOnInAMapFromWhereItIsToldTheLogBegins) {
  ASSERT_OK(Run({File("drive.jsonl", Log(11)), "-o", out_}));
  const std::string map = out_ / "map.yaml";
  const std::filesystem::path both = directory_.path() / "both";
  // The same drive again: it begins at the map's origin, which is told wrong by 0.4 m and 0.1 rad.
  ASSERT_OK(
      Run({File("again.jsonl", Log(11)), "--on", map, "--at", "-0.4,0.2,0.1", "--at-sigma", "0.3,0.1", "-o", both}));
  EXPECT_EQ(Report()["submaps"], 2) << "the existing map and its own";
  EXPECT_GT(Report()["closures_accepted"], 0);
  std::istringstream first(Content(both / "trajectory.txt"));
  double t = 0.0, x = 0.0, y = 0.0, yaw = 0.0;
  first >> t >> x >> y >> yaw;
  EXPECT_NEAR(x, 0.0, 0.05);
  EXPECT_NEAR(y, 0.0, 0.05);
  EXPECT_NEAR(yaw, 0.0, 0.02);
  EXPECT_TRUE(std::filesystem::exists(both / "map.pgm"));
}

TEST_F(SlamTest, RefusesAnEntryThatIsHalfSaidOrNoPose) {
  const std::string log = File("drive.jsonl", Log(1));
  const auto refuses = [&](std::vector<std::string> arguments, const char* why) {
    arguments.insert(arguments.begin(), log);
    EXPECT_STATUS(Run(arguments), absl::StatusCode::kInvalidArgument, HasSubstr(why));
  };
  refuses({"--at", "1,2,3"}, "--on");
  refuses({"--on", "map.yaml"}, "--at");
  for (const char* at : {"1,2", "1,2,3,4", "a,b,c", "1,2,", "1,2,nan"}) {
    refuses({"--on", "map.yaml", "--at", at}, "X,Y,YAW");
  }
  refuses({"--on", "map.yaml", "--at", "1,2,3", "--at-sigma", "0,1"}, "--at-sigma");
  EXPECT_STATUS(Run({log, "--on", directory_.path() / "none.yaml", "--at", "1,2,3"}), absl::StatusCode::kNotFound,
                HasSubstr("none.yaml"));
}

TEST_F(SlamTest, ReportsScansSecondsAndRateToPeople) {
  ASSERT_OK(Run({File("drive.jsonl", Log(3))}, false));
  EXPECT_THAT(printed_, HasSubstr("3 scans (3 used"));
  EXPECT_THAT(printed_, HasSubstr("scans/s"));
}

TEST_F(SlamTest, PlotsTheTrajectoryOverTheMap) {
  ASSERT_OK(Run({File("drive.jsonl", Log(11)), "-o", out_, "--plot"}));
  EXPECT_TRUE(Content(out_ / "plot.png").starts_with("\x89PNG"));
  EXPECT_NE(Content(out_ / "plot.png"), Content(out_ / "map.png"));
  EXPECT_STATUS(Run({File("drive.jsonl", Log(1)), "--plot"}), absl::StatusCode::kInvalidArgument, HasSubstr("-o DIR"));
}

TEST_F(SlamTest, LeavesTheOdometryOutWhereToldTo) {
  ASSERT_OK(Run({File("drive.jsonl", Log(11)), "-o", out_, "--no-odometry"}));
  EXPECT_EQ(Report()["used"], 11);
  EXPECT_EQ(Report()["without_odometry"], 11);
  std::istringstream last(Content(out_ / "trajectory.txt"));
  double t = 0.0, x = 0.0, y = 0.0, yaw = 0.0;
  while (last >> t >> x >> y >> yaw) {
  }
  EXPECT_NEAR(x, 2.0, 0.05);
  EXPECT_NEAR(y, 1.0, 0.05);
}

TEST_F(SlamTest, TakesItsOptionsFromAFile) {
  const std::string log = File("drive.jsonl", Log(11));
  ASSERT_OK(Run({log}));
  const int keyframes = Report()["keyframes"];
  ASSERT_OK(Run({log, "--options", File("slam.yaml", "keyframe:\n  distance: 0.01\n")}));
  EXPECT_EQ(Report()["keyframes"], 11);
  EXPECT_LT(keyframes, 11);
}

TEST_F(SlamTest, RefusesOptionsThatItDoesNotKnowOrCannotUse) {
  const std::string log = File("drive.jsonl", Log(1));
  const std::string unknown = File("slam.yaml", "keyframe:\n  distanse: 0.3\n");
  EXPECT_STATUS(Run({log, "--options", unknown}), absl::StatusCode::kInvalidArgument,
                HasSubstr("no option keyframe.distanse"));
  EXPECT_STATUS(Run({log, "--options", unknown}), absl::StatusCode::kInvalidArgument, HasSubstr("slam.yaml"));
  EXPECT_STATUS(Run({log, "--options", File("slam.yaml", "max_range: -1\n")}), absl::StatusCode::kInvalidArgument,
                HasSubstr("max_range"));
  EXPECT_STATUS(Run({log, "--options", File("slam.yaml", "max_range: [")}), absl::StatusCode::kInvalidArgument,
                HasSubstr("slam.yaml"));
  EXPECT_STATUS(Run({log, "--options", out_}), absl::StatusCode::kNotFound, HasSubstr("out"));
}

TEST_F(SlamTest, PrintsOptionsThatItTakes) {
  ASSERT_OK(Run({"--print-options"}, false));
  const std::string options = File("slam.yaml", printed_);
  ASSERT_OK(Run({File("drive.jsonl", Log(3)), "--options", options}));
  EXPECT_EQ(Report()["used"], 3);
}

TEST_F(SlamTest, MakesNoMapOfAnEmptyLog) {
  const std::string log = File("empty.jsonl", sources::JsonLinesHeader());
  ASSERT_OK(Run({log, "-o", out_, "--plot"}));
  EXPECT_EQ(Report()["scans"], 0);
  EXPECT_EQ(Report()["submaps"], 0);
  EXPECT_EQ(Report()["scans_per_second"], 0.0);
  EXPECT_EQ(Content(out_ / "trajectory.txt"), "");
  EXPECT_TRUE(nlohmann::json::parse(Content(out_ / "closures.json"))["closures"].empty());
  EXPECT_FALSE(std::filesystem::exists(out_ / "map.pgm"));
}

TEST_F(SlamTest, MapsOneScan) {
  ASSERT_OK(Run({File("one.jsonl", Log(1)), "-o", out_}));
  EXPECT_EQ(Report()["keyframes"], 1);
  EXPECT_EQ(Content(out_ / "trajectory.txt"), "1700000000.000000000 0 0 0\n");
  EXPECT_TRUE(std::filesystem::exists(out_ / "map.png"));
}

TEST_F(SlamTest, UsesNoScanWhoseBeamsAreAllOutOfRange) {
  const std::string log = File("far.jsonl", Log(5, false));
  ASSERT_OK(Run({log, "--no-odometry", "-o", out_}));
  EXPECT_EQ(Report()["scans"], 5);
  EXPECT_EQ(Report()["used"], 0);
  EXPECT_EQ(Content(out_ / "trajectory.txt"), "");
}

TEST_F(SlamTest, SaysWhichLogCannotBeRead) {
  EXPECT_STATUS(Run({directory_.path() / "absent.log"}), absl::StatusCode::kNotFound, HasSubstr("absent.log"));
  const std::string log = File("bad.jsonl", Log(1) + "{\"scan\": oops\n");
  EXPECT_STATUS(Run({log}), absl::StatusCode::kInvalidArgument, HasSubstr("bad.jsonl:4"));
  EXPECT_OK(Run({log, "--skip-bad-lines"}));
  EXPECT_EQ(Report()["scans"], 1);
  EXPECT_STATUS(Run({}), absl::StatusCode::kInvalidArgument, HasSubstr("LOG"));
}

TEST_F(SlamTest, SaysWhereItCannotWrite) {
  const std::string file = File("taken", "a file where a folder should be");
  EXPECT_STATUS(Run({File("drive.jsonl", Log(1)), "-o", file}), absl::StatusCode::kFailedPrecondition,
                HasSubstr("taken"));
}

}  // namespace
}  // namespace enfilade::cli
