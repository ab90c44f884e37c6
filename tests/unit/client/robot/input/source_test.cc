// SPDX-License-Identifier: Apache-2.0
#include "client/robot/input/source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::robot {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryDirectory;

class LinesTest : public ::testing::Test {
 protected:
  LinesTest() {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    write_ = ends[1];
    read_ = ends[0];
    source_ = OpenLines(read_, directory_.path(), Eigen::Matrix3d::Identity());
  }
  ~LinesTest() override {
    Close();
    close(read_);
  }
  void Write(const std::string& text) {
    ASSERT_EQ(write(write_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void Close() {
    if (write_ >= 0) close(write_);
    write_ = -1;
  }
  Input Next() {
    absl::StatusOr<Input> input = source_->Next();
    EXPECT_OK(input.status());
    return input.ok() ? *std::move(input) : Input(Ended{});
  }

  TemporaryDirectory directory_;
  int write_ = -1;
  int read_ = -1;
  std::unique_ptr<Source> source_;
};

constexpr const char* kOdometry =
    "{\"type\":\"odometry\",\"time_ns\":1000000000,\"pose\":{\"x_m\":1.5,\"y_m\":0,\"yaw_rad\":0}}\n";

TEST_F(LinesTest, GivesLinesAsTheyCome) {
  EXPECT_TRUE(std::holds_alternative<Idle>(Next()));
  const std::string line = kOdometry;
  Write(line.substr(0, 20));
  EXPECT_TRUE(std::holds_alternative<Idle>(Next())) << "half a line";
  Write(line.substr(20));
  const Input input = Next();
  ASSERT_TRUE(std::holds_alternative<client::SpoolItem>(input));
  EXPECT_EQ(std::get<sensor::Odometry>(std::get<client::SpoolItem>(input).payload).T_odom_robot.x, 1.5);
  EXPECT_TRUE(std::holds_alternative<Idle>(Next()));
  Close();
  EXPECT_TRUE(std::holds_alternative<Ended>(Next()));
  EXPECT_TRUE(std::holds_alternative<Ended>(Next()));
}

TEST_F(LinesTest, TakesALastLineWithoutAnEnd) {
  const std::string line = kOdometry;
  Write(line.substr(0, line.size() - 1));
  Close();
  EXPECT_TRUE(std::holds_alternative<client::SpoolItem>(Next()));
  EXPECT_TRUE(std::holds_alternative<Ended>(Next()));
}

TEST_F(LinesTest, ReadsCommandsAndPosesAmongTheRecords) {
  Write("# a comment\n\n{\"type\":\"command\",\"command\":\"set_candidate\"}\n");
  Write("{\"type\":\"pose\",\"map\":\"hall\",\"time_ns\":5,\"pose\":{\"x_m\":1,\"y_m\":2,\"yaw_rad\":0.5}}\n");
  EXPECT_TRUE(std::holds_alternative<SetCandidate>(std::get<Command>(Next())));
  const PoseReport pose = std::get<PoseReport>(Next());
  EXPECT_EQ(pose.map, "hall");
  EXPECT_EQ(pose.time, 5);
  EXPECT_EQ(pose.T_map_robot.pose, (Pose2{1.0, 2.0, 0.5}));
  EXPECT_EQ(pose.T_map_robot.covariance, Eigen::Matrix3d::Identity());
}

TEST_F(LinesTest, BringsThePictureFilesAlong) {
  std::ofstream(directory_.path() / "a.png", std::ios::binary) << "picture";
  Write("{\"type\":\"image\",\"time_ns\":5,\"camera\":\"rear\",\"encoding\":\"png\",\"file\":\"a.png\"}\n");
  EXPECT_EQ(std::get<client::SpoolItem>(Next()).content, "picture");
}

TEST_F(LinesTest, ReportsBadLinesWithTheirNumberAndGoesOn) {
  Write("nonsense\n{\"type\":\"scan\"}\n{\"type\":\"command\",\"command\":\"fly\"}\n");
  Write("{\"type\":\"pose\",\"map\":\"m\",\"time_ns\":5}\n");
  Write("{\"type\":\"image\",\"time_ns\":5,\"camera\":\"rear\",\"encoding\":\"png\",\"file\":\"missing.png\"}\n");
  Write(kOdometry);
  for (const auto& [where, what] :
       {std::pair("line 1:", "JSON"), std::pair("line 2:", "time_ns"), std::pair("line 3:", "not a command"),
        std::pair("line 4:", "pose"), std::pair("line 5:", "missing.png")}) {
    const Input input = Next();
    ASSERT_TRUE(std::holds_alternative<BadInput>(input)) << where;
    EXPECT_THAT(std::get<BadInput>(input).message, HasSubstr(where));
    EXPECT_THAT(std::get<BadInput>(input).message, HasSubstr(what));
  }
  EXPECT_TRUE(std::holds_alternative<client::SpoolItem>(Next()));
}

TEST(OpenSimulation, DrivesTheSameWithTheSameSeedAndWritesTheTruth) {
  TemporaryDirectory directory;
  simulator::SimulationOptions options;
  options.scan_hz = 1.0;
  const std::string truth = (directory.path() / "truth.jsonl").string();
  ASSERT_OK_AND_ASSIGN(const auto source, OpenSimulation("rooms", "robot", options, truth));
  int items = 0;
  while (true) {
    ASSERT_OK_AND_ASSIGN(const Input input, source->Next());
    if (std::holds_alternative<Ended>(input)) break;
    items += std::holds_alternative<client::SpoolItem>(input) ? 1 : 0;
  }
  EXPECT_GT(items, 1000);
  EXPECT_TRUE(std::filesystem::exists(truth));
  EXPECT_FALSE(OpenSimulation("rooms", "nobody", options, "").ok());
  EXPECT_FALSE(OpenSimulation("nowhere", "r1", options, "").ok());
}

TEST(OpenSimulation, TellsTheLevelOnceTheLiftIsThere) {
  simulator::SimulationOptions options;
  options.scan_hz = 1.0;
  ASSERT_OK_AND_ASSIGN(const auto source, OpenSimulation("levels", "r1", options, ""));
  std::vector<std::int32_t> levels;
  int before = 0;
  int behind = 0;
  while (true) {
    ASSERT_OK_AND_ASSIGN(const Input input, source->Next());
    if (std::holds_alternative<Ended>(input)) break;
    const auto* command = std::get_if<Command>(&input);
    if (command != nullptr && std::holds_alternative<EnterLevel>(*command)) {
      levels.push_back(std::get<EnterLevel>(*command).level);
    }
    if (std::holds_alternative<client::SpoolItem>(input)) ++(levels.empty() ? before : behind);
  }
  EXPECT_THAT(levels, ::testing::ElementsAre(1));
  EXPECT_GT(before, 100);
  EXPECT_GT(behind, 100);
}

TEST(OpenLog, EndsAtABadLineUnlessToldToGoOn) {
  TemporaryDirectory directory;
  const std::string path = (directory.path() / "log.jsonl").string();
  std::ofstream(path) << kOdometry << "nonsense\n" << kOdometry;
  ASSERT_OK_AND_ASSIGN(const auto strict, OpenLog(path, {}));
  EXPECT_OK(strict->Next().status());
  EXPECT_FALSE(strict->Next().ok());
  sources::LogOptions options;
  options.skip_bad_lines = true;
  ASSERT_OK_AND_ASSIGN(const auto lenient, OpenLog(path, options));
  EXPECT_OK(lenient->Next().status());
  ASSERT_OK_AND_ASSIGN(const Input second, lenient->Next());
  EXPECT_TRUE(std::holds_alternative<client::SpoolItem>(second));
  ASSERT_OK_AND_ASSIGN(const Input end, lenient->Next());
  EXPECT_TRUE(std::holds_alternative<Ended>(end));
}

}  // namespace
}  // namespace enfilade::robot
