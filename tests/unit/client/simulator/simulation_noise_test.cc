// SPDX-License-Identifier: Apache-2.0
// Noise, rates and options of a simulated drive.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <set>

#include "client/simulator/campus/campus_yaml.h"
#include "client/simulator/simulation.h"
#include "core/base/noise.h"
#include "core/base/sha256.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<const World> StraightRoad() {
  absl::StatusOr<Campus> campus = ParseCampus(R"(
areas: [{id: road, kind: outdoor, rect: [-2, -2, 44, 4]}, {id: shed, rect: [42, -2, 4, 4]}]
doors: [{id: gate, from: [42, -0.5], to: [42, 0.5]}]
boxes: [{rect: [10, 1, 1, 1]}]
robots: [{id: r, route: [[0, 0], [40, 0]]}, {id: q, route: [[0, 0], [40, 0]]}]
)");
  EXPECT_OK(campus.status());
  return std::make_shared<const World>(*std::move(campus));
}

SimulationOptions WheelsOnly() {
  SimulationOptions options;
  options.scan_hz = 1.0;
  options.scanner.beams = 8;
  return options;
}

// The distance driven, m, as the wheels measured it, minus the true one. Unlike the last pose it does not depend on the
// errors of the heading.
double LengthError(const Drive& drive) {
  double length = 0.0;
  Pose2 last;
  for (const SimulatedRecord& record : drive.records) {
    const auto* odometry = std::get_if<sensor::Odometry>(&record.payload);
    if (!odometry) continue;
    length += (odometry->T_odom_robot.translation() - last.translation()).norm();
    last = odometry->T_odom_robot;
  }
  return length - drive.truth.travelled;
}

// Of the drives with seeds from 0 on.
struct Moments {
  double mean = 0.0;
  double sigma = 0.0;
};
Moments LengthErrors(SimulationOptions options, int drives) {
  const auto world = StraightRoad();
  double sum = 0.0;
  double squares = 0.0;
  for (int seed = 0; seed < drives; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    const absl::StatusOr<Drive> drive = SimulateDrive(world, "r", options);
    EXPECT_OK(drive.status());
    const double error = LengthError(*drive) / drive->truth.travelled;
    sum += error;
    squares += error * error;
  }
  return {sum / drives, std::sqrt(squares / drives)};
}

TEST(WheelNoise, ScalesTheDistanceByTheWheelsSizes) {
  SimulationOptions options = WheelsOnly();
  options.slip = 0.0;
  options.wheel_sigma = 0.02;
  const Moments errors = LengthErrors(options, 60);
  // The mean of two independent factors of 2 % each: 1.41 %.
  EXPECT_NEAR(errors.sigma, 0.02 / std::sqrt(2.0), 0.005);
  EXPECT_NEAR(errors.mean, 0.0, 0.006);
}

TEST(WheelNoise, SlipGrowsWithTheSquareRootOfTheDistance) {
  SimulationOptions options = WheelsOnly();
  options.wheel_sigma = 0.0;
  options.slip = 0.004;
  const Moments errors = LengthErrors(options, 100);
  // 0.004 m per root of a metre on each of two wheels, over 40 m.
  const double expected = 0.004 / std::sqrt(2.0 * 40.0);
  EXPECT_NEAR(errors.sigma, expected, 0.25 * expected);
}

TEST(WheelNoise, WithoutItOdometryMeasuresTheTruth) {
  SimulationOptions options = WheelsOnly();
  options.wheel_sigma = options.slip = 0.0;
  EXPECT_NEAR(LengthErrors(options, 1).sigma, 0.0, 1e-9);
}

TEST(WheelNoise, RobotsOfOneSeedDiffer) {
  const auto world = StraightRoad();
  ASSERT_OK_AND_ASSIGN(const Drive one, SimulateDrive(world, "r", WheelsOnly()));
  ASSERT_OK_AND_ASSIGN(const Drive two, SimulateDrive(world, "q", WheelsOnly()));
  ASSERT_EQ(one.records.size(), two.records.size());
  EXPECT_NE(one.records.back().payload, two.records.back().payload);
}

TEST(Noise, HasTheMomentsThatItPromises) {
  Noise noise(12);
  double sum = 0.0;
  double squares = 0.0;
  double uniform = 0.0;
  std::map<int, int> counts;
  constexpr int kCount = 20'000;
  for (int i = 0; i < kCount; ++i) {
    const double normal = noise.Normal();
    sum += normal;
    squares += normal * normal;
    const double u = noise.Uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    uniform += u;
    ++counts[noise.Below(5)];
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.03);
  EXPECT_NEAR(squares / kCount, 1.0, 0.04);
  EXPECT_NEAR(uniform / kCount, 0.5, 0.01);
  ASSERT_EQ(counts.size(), 5U);
  for (const auto& [value, count] : counts) EXPECT_NEAR(count, kCount / 5, kCount / 50) << value;
}

TEST(Noise, EveryReadingHasItsOwn) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t robot = 0; robot < 5; ++robot) {
    for (std::uint64_t sensor = 0; sensor < 6; ++sensor) {
      for (std::uint64_t index = 0; index < 100; ++index) seeds.insert(Mix(Mix(1, robot), sensor, index));
    }
  }
  EXPECT_EQ(seeds.size(), 5U * 6U * 100U);
  EXPECT_NE(SeedOf("r1"), SeedOf("r2"));
  EXPECT_EQ(SeedOf(""), 0xCBF29CE484222325ULL) << "the offset basis of FNV-1a";
}

SimulationOptions AllSensors() {
  SimulationOptions options;
  options.cloud_hz = 1.0;
  options.image_hz = 0.5;
  options.depth_hz = 0.5;
  options.camera.width = 32;
  options.camera.height = 24;
  options.cloud.azimuths = 20;
  options.scanner.beams = 16;
  return options;
}

TEST(SimulatedRecords, AreTheSameForTheSameSeedToTheLastByte) {
  const auto world = StraightRoad();
  ASSERT_OK_AND_ASSIGN(const Drive one, SimulateDrive(world, "r", AllSensors()));
  ASSERT_OK_AND_ASSIGN(const Drive two, SimulateDrive(StraightRoad(), "r", AllSensors()));
  SimulationOptions options = AllSensors();
  options.seed = 2;
  ASSERT_OK_AND_ASSIGN(const Drive other, SimulateDrive(world, "r", options));
  ASSERT_EQ(one.records.size(), two.records.size());
  ASSERT_EQ(one.records.size(), other.records.size());
  int contents = 0;
  for (std::size_t i = 0; i < one.records.size(); ++i) {
    ASSERT_EQ(one.records[i].content, two.records[i].content) << i;
    if (one.records[i].content.empty()) continue;
    ++contents;
    ASSERT_NE(one.records[i].content, other.records[i].content) << i;
    const sensor::BlobRef& blob = *sensor::FindBlob(one.records[i].payload);
    EXPECT_EQ(blob.size, static_cast<std::int64_t>(one.records[i].content.size()));
    EXPECT_EQ(blob.sha256, Sha256(one.records[i].content));
  }
  EXPECT_GT(contents, 100);
}

TEST(SimulatedRecords, ComeAtTheirRates) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(StraightRoad(), "r", AllSensors()));
  std::map<std::size_t, int> counts;
  for (const SimulatedRecord& record : drive.records) ++counts[record.payload.index()];
  const double seconds = ToSeconds(drive.truth.poses.back().time - drive.truth.poses.front().time);
  const auto rate = [&](const sensor::RecordPayload& sample) { return counts[sample.index()] / seconds; };
  EXPECT_NEAR(rate(sensor::Odometry{}), 20.0, 0.5);
  EXPECT_NEAR(rate(sensor::LaserScan{}), 5.0, 0.2);
  EXPECT_NEAR(rate(sensor::PointCloud{}), 1.0, 0.05);
  EXPECT_NEAR(rate(sensor::Image{}), 3 * 0.5, 0.1) << "front, rear and depth";
}

TEST(SimulatedRecords, ImagesAndCloudsComeOnlyNearDoorsIfLimited) {
  SimulationOptions options = AllSensors();
  options.near_doors = 5.0;
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(StraightRoad(), "r", options));
  std::map<TimeNs, Pose2> truth;
  for (const TruePose& pose : drive.truth.poses) truth[pose.time] = pose.T_campus_robot;
  int seen = 0;
  for (const SimulatedRecord& record : drive.records) {
    if (record.content.empty()) continue;
    ++seen;
    const TimeNs time = sensor::TimeOf(sensor::Record{1, record.payload});
    ASSERT_TRUE(truth.contains(time));
    EXPECT_GE(truth[time].x, 37.0 - 0.1) << "the gate is at 42 m";
  }
  EXPECT_GT(seen, 5);
}

struct BadOption {
  const char* name;
  std::function<void(SimulationOptions&)> set;
  const char* message;
};

class SimulationOptionErrors : public ::testing::TestWithParam<BadOption> {};

TEST_P(SimulationOptionErrors, AreRefused) {
  SimulationOptions options;
  GetParam().set(options);
  EXPECT_STATUS(options.Validate(), absl::StatusCode::kInvalidArgument, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    All, SimulationOptionErrors,
    ::testing::Values(
        BadOption{"Speed", [](auto& o) { o.motion.speed = 0.0; }, "speed is 0"},
        BadOption{"TurnRate", [](auto& o) { o.motion.turn_rate = -1.0; }, "turn_rate is -1"},
        BadOption{"OdometryRate", [](auto& o) { o.odometry_hz = 0.0; }, "odometry_hz is 0"},
        BadOption{"Track", [](auto& o) { o.track = NAN; }, "track is nan"},
        BadOption{"Laps", [](auto& o) { o.laps = 1001; }, "laps is 1001: expected 1 to 1000"},
        BadOption{"ScanRate", [](auto& o) { o.scan_hz = 21.0; }, "scan_hz is 21: expected 0 to odometry_hz (20)"},
        BadOption{"CloudRate", [](auto& o) { o.cloud_hz = -1.0; }, "cloud_hz is -1"},
        BadOption{"ImageRate", [](auto& o) { o.image_hz = NAN; }, "image_hz is nan"},
        BadOption{"DepthRate", [](auto& o) { o.depth_hz = 99.0; }, "depth_hz is 99"},
        BadOption{"Slip", [](auto& o) { o.slip = -0.1; }, "slip"},
        BadOption{"TooFast", [](auto& o) { o.motion.speed = 4.0; }, "too fast for an odometry rate of 20 Hz"},
        BadOption{"OneBeam", [](auto& o) { o.scanner.beams = 1; }, "beams is 1: expected 2 to 100000"},
        BadOption{"MoreThanATurn", [](auto& o) { o.scanner.field_of_view = 7.0; }, "field_of_view is 7 rad"},
        BadOption{"EmptyRange", [](auto& o) { o.scanner.range_max = 0.01; }, "range_min below range_max"},
        BadOption{"Dropout", [](auto& o) { o.scanner.dropout = 1.5; }, "dropout 1.5"},
        BadOption{"Sigma", [](auto& o) { o.scanner.range_sigma = -1.0; }, "range_sigma is -1"},
        BadOption{"TinyCamera", [](auto& o) { o.camera.width = 4; }, "a camera of 4 x 384 pixels"},
        BadOption{"FishEye", [](auto& o) { o.camera.field_of_view = 3.1; }, "field of view of 3.1 rad"}),
    [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace enfilade::simulator
