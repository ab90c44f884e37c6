// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/simulation_files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "client/sources/content.h"
#include "client/sources/log_reader.h"
#include "nlohmann/json.hpp"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::simulator {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryDirectory;

constexpr const char* kTwoAreas = R"(campus: two
areas:
  - {id: a, rect: [0, 0, 4, 4], doors: [{id: d, side: east, at: 2, width: 1}]}
  - {id: b, rect: [4, 0, 4, 4]}
robots: [{id: r, route: [[1, 2], {door: d}, [7, 2]]}]
)";

std::string TextOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(LoadCampus, FindsFilesShippedCampusesAndRandomBuildings) {
  const TemporaryDirectory directory;
  const std::string path = (directory.path() / "two.yaml").string();
  std::ofstream(path) << kTwoAreas;
  ASSERT_OK_AND_ASSIGN(const Campus file, LoadCampus(path));
  EXPECT_EQ(file.name, "two");
  ASSERT_OK_AND_ASSIGN(const Campus shipped, LoadCampus("rooms"));
  EXPECT_EQ(shipped.name, "rooms");
  ASSERT_OK_AND_ASSIGN(const Campus random, LoadCampus("random:18446744073709551615"));
  EXPECT_EQ(random.name, "random-18446744073709551615");
  ASSERT_OK_AND_ASSIGN(const Campus suites, LoadCampus("suites:7"));
  EXPECT_EQ(suites.name, "suites-7");
}

TEST(LoadCampus, NamesWhatIsWrong) {
  const TemporaryDirectory directory;
  const std::string path = (directory.path() / "bad.yaml").string();
  std::ofstream(path) << "campus: x\narea: []\n";
  EXPECT_STATUS(LoadCampus(path), absl::StatusCode::kInvalidArgument, HasSubstr("bad.yaml: line 2: "));
  EXPECT_STATUS(LoadCampus("nowhere"), absl::StatusCode::kNotFound, HasSubstr("rooms"));
  EXPECT_CODE(LoadCampus(directory.path().string()), absl::StatusCode::kNotFound);
  for (const char* name : {"random:", "random:x", "random:1x", "random:-1", "random:99999999999999999999"}) {
    EXPECT_STATUS(LoadCampus(name), absl::StatusCode::kInvalidArgument, HasSubstr("expected random:SEED")) << name;
  }
  EXPECT_STATUS(LoadCampus("suites:x"), absl::StatusCode::kInvalidArgument, HasSubstr("expected suites:SEED"));
}

class WriteDriveTest : public ::testing::Test {
 protected:
  WriteDriveTest() {
    const TemporaryDirectory campus;
    std::ofstream(campus.path() / "two.yaml") << kTwoAreas;
    world_ = std::make_shared<const World>(*LoadCampus((campus.path() / "two.yaml").string()));
    options_.image_hz = options_.depth_hz = 0.5;
    options_.cloud_hz = 0.5;
    options_.camera.width = 32;
    options_.camera.height = 24;
    options_.cloud.azimuths = 12;
  }

  TemporaryDirectory directory_;
  std::shared_ptr<const World> world_;
  SimulationOptions options_;
};

TEST_F(WriteDriveTest, WritesALogThatReadsBackAsTheSimulatedRecords) {
  ASSERT_OK_AND_ASSIGN(const DriveReport report, WriteDrive(world_, "r", options_, directory_.path() / "new" / "r"));
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(world_, "r", options_));
  ASSERT_OK_AND_ASSIGN(sources::LogReader reader, sources::LogReader::Open(report.log));
  for (const SimulatedRecord& record : drive.records) {
    ASSERT_OK_AND_ASSIGN(const std::optional<sources::LogEntry> entry, reader.Next());
    ASSERT_TRUE(entry.has_value());
    if (const auto* scan = std::get_if<sensor::LaserScan>(&record.payload)) {
      const auto& read = std::get<sensor::LaserScan>(entry->payload);
      ASSERT_EQ(read.ranges.size(), scan->ranges.size());
      for (std::size_t i = 0; i < read.ranges.size(); ++i) {
        ASSERT_TRUE(read.ranges[i] == scan->ranges[i] || (std::isnan(read.ranges[i]) && std::isnan(scan->ranges[i])));
      }
    } else {
      ASSERT_EQ(entry->payload, record.payload);
    }
    if (record.content.empty()) continue;
    ASSERT_OK_AND_ASSIGN(const std::string content, sources::ReadContent(entry->content));
    ASSERT_EQ(content, record.content);
  }
  ASSERT_OK_AND_ASSIGN(const std::optional<sources::LogEntry> end, reader.Next());
  EXPECT_FALSE(end.has_value());
  EXPECT_EQ(report.scans, reader.counts().scans);
  EXPECT_EQ(report.odometry, reader.counts().odometry);
  EXPECT_EQ(report.images, reader.counts().images);
  EXPECT_EQ(report.clouds, reader.counts().point_clouds);
  EXPECT_GT(report.images, 5);
  EXPECT_GT(report.seconds, 5.0);
}

TEST_F(WriteDriveTest, WritesTheTruthInOrderOfTime) {
  ASSERT_OK_AND_ASSIGN(const DriveReport report, WriteDrive(world_, "r", options_, directory_.path()));
  std::istringstream lines(TextOf(directory_.path() / "truth.jsonl"));
  std::int64_t last = 0;
  int poses = 0;
  std::vector<nlohmann::json> passages;
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json object = nlohmann::json::parse(line);
    EXPECT_GE(object.at("time_ns").get<std::int64_t>(), last);
    last = object.at("time_ns");
    if (object.at("type") == "passage") passages.push_back(object);
    if (object.at("type") == "pose") ++poses;
  }
  EXPECT_EQ(poses, report.scans);
  ASSERT_EQ(passages.size(), 1U);
  EXPECT_EQ(passages[0].at("door"), "d");
  EXPECT_EQ(passages[0].at("from"), "a");
  EXPECT_EQ(passages[0].at("to"), "b");
  EXPECT_NEAR(passages[0].at("width_m").get<double>(), 1.0, 1e-9);
  EXPECT_NEAR(passages[0].at("pose").at("x_m").get<double>(), 4.0, 1e-6);
  EXPECT_LT(passages[0].at("incidence_rad").get<double>(), 0.1);
}

TEST_F(WriteDriveTest, WritesTheTrajectoryWithItsTimes) {
  ASSERT_OK_AND_ASSIGN(const DriveReport report, WriteDrive(world_, "r", options_, directory_.path()));
  std::istringstream lines(TextOf(directory_.path() / "truth.txt"));
  std::size_t count = 0;
  double time = 0.0;
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
  while (lines >> time >> x >> y >> yaw) {
    ASSERT_LT(count, report.truth.poses.size());
    const TruePose& pose = report.truth.poses[count++];
    EXPECT_NEAR(time, ToSeconds(pose.time), 1e-6);
    EXPECT_EQ(x, pose.T_campus_robot.x);
    EXPECT_EQ(y, pose.T_campus_robot.y);
    EXPECT_EQ(yaw, pose.T_campus_robot.yaw);
  }
  EXPECT_EQ(count, report.truth.poses.size());
}

TEST_F(WriteDriveTest, FailsIfItCannotWrite) {
  std::ofstream(directory_.path() / "file") << "in the way";
  EXPECT_CODE(WriteDrive(world_, "r", options_, directory_.path() / "file" / "r"),
              absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(WriteDrive(world_, "nobody", options_, directory_.path() / "n"), absl::StatusCode::kNotFound);
  EXPECT_FALSE(std::filesystem::exists(directory_.path() / "n")) << "nothing is created for a bad robot";
}

TEST_F(WriteDriveTest, DescribesItsSensors) {
  const nlohmann::json sensors = nlohmann::json::parse(SensorDescription(options_));
  EXPECT_EQ(sensors.at("camera").at("width"), 32);
  EXPECT_NEAR(sensors.at("camera").at("focal_length_px").get<double>(), options_.camera.focal_length(), 1e-12);
  EXPECT_NEAR(std::abs(sensors.at("camera").at("rear_mount").at("yaw_rad").get<double>()), M_PI, 1e-12);
  EXPECT_EQ(sensors.at("cloud_scanner").at("azimuths"), 12);
}

}  // namespace
}  // namespace enfilade::simulator
