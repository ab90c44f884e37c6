// SPDX-License-Identifier: Apache-2.0
#include "client/sources/log_reader.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/sources/formats/fields.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/sources/log_files.h"

namespace enfilade::sources {
namespace {

using sources::LogFormat;
using sources::LogOptions;
using testing::AllOf;
using testing::Contents;
using ::testing::HasSubstr;
using testing::LogFiles;
using testing::PoseNear;
using testing::ReadAll;
using testing::ReadLog;

constexpr auto kMalformed = absl::StatusCode::kInvalidArgument;

TEST(LogReader, RefusesWhatIsNoLog) {
  const LogFiles files;
  EXPECT_STATUS(ReadAll(files.path() / "none.log").status, absl::StatusCode::kNotFound,
                HasSubstr("none.log: no such file"));
  EXPECT_STATUS(ReadAll(files.path()).status, kMalformed, HasSubstr("is a directory"));
  EXPECT_STATUS(ReadAll(files.Write("empty.log", "")).status, kMalformed, HasSubstr("the log is empty"));
  EXPECT_STATUS(ReadAll(files.Write("comments.log", "# nothing\n\n")).status, kMalformed, HasSubstr("2 lines"));
  EXPECT_STATUS(ReadAll(files.Write("prose.log", "once upon a time\n")).status, kMalformed,
                HasSubstr("prose.log:1: unknown format"));
  EXPECT_STATUS(ReadAll(files.Write("elf.log", std::string("\x7f"
                                                           "ELF\x02\x01\x01\0\0",
                                                           9)))
                    .status,
                kMalformed, HasSubstr("binary data"));
}

TEST(LogReader, ReadsCompressedLogsLikePlainOnes) {
  const LogFiles files;
  const auto plain = testing::ProjectData("logs/small.clf");
  const ReadLog compressed = ReadAll(files.WriteGz("small.clf.gz", Contents(plain)));
  EXPECT_OK(compressed.status);
  EXPECT_EQ(compressed.entries, ReadAll(plain).entries);
}

TEST(LogReader, ReadsLinesThatEndAsOnOtherSystems) {
  const LogFiles files;
  std::string text = Contents(testing::ProjectData("logs/small.clf"));
  const ReadLog plain = ReadAll(testing::ProjectData("logs/small.clf"));
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.replace(at, 1, "\r\n");
  EXPECT_EQ(ReadAll(files.Write("dos.clf", text)).entries, plain.entries);
  text.resize(text.size() - 2);
  EXPECT_EQ(ReadAll(files.Write("unended.clf", text)).entries, plain.entries);
}

TEST(LogReader, NamesTheLineWhereCompressedDataIsCutOffOrDamaged) {
  const LogFiles files;
  std::string text;
  for (int i = 0; i < 20'000; ++i)
    text += "ODOM " + std::to_string(i * 7919 % 1000) + " 0 0 0 0 0 " + std::to_string(i) + " h 0\n";
  const auto path = files.WriteGz("whole.log.gz", text);
  const std::string whole = Contents(path);
  ASSERT_EQ(ReadAll(path).entries.size(), 20'000U);

  const ReadLog cut = ReadAll(files.Write("cut.log.gz", whole.substr(0, whole.size() / 2)));
  EXPECT_STATUS(cut.status, kMalformed, HasSubstr("cut.log.gz:"));
  EXPECT_STATUS(cut.status, kMalformed, HasSubstr("damaged or cut off"));
  std::string damaged = whole;
  for (std::size_t i = 0; i < 64; ++i) damaged[damaged.size() / 2 + i] = static_cast<char>(0xA5 ^ i);
  EXPECT_STATUS(ReadAll(files.Write("damaged.log.gz", damaged)).status, kMalformed, HasSubstr("damaged.log.gz:"));
  std::string checksum = whole;
  checksum[checksum.size() - 6] = static_cast<char>(checksum[checksum.size() - 6] ^ 1);
  EXPECT_STATUS(ReadAll(files.Write("sum.log.gz", checksum)).status, kMalformed, HasSubstr("damaged or cut off"));
}

TEST(LogReader, SkippingBadLinesStillEndsWithCutOffData) {
  const LogFiles files;
  const std::string whole = Contents(files.WriteGz("w.log.gz", Contents(testing::ProjectData("logs/small.clf"))));
  LogOptions options;
  options.skip_bad_lines = true;
  EXPECT_STATUS(ReadAll(files.Write("cut.log.gz", whole.substr(0, whole.size() - 9)), options).status, kMalformed,
                HasSubstr("cut off"));
}

TEST(LogReader, ReadsWeanHallLogsInCentimetres) {
  const ReadLog log = ReadAll(testing::ProjectData("logs/wean_hall.log"));
  ASSERT_OK(log.status);
  EXPECT_EQ(log.facts.format, LogFormat::kWeanHall);
  ASSERT_EQ(log.entries.size(), 4U);
  EXPECT_THAT(std::get<sensor::Odometry>(log.entries[0].payload).T_odom_robot,
              PoseNear(Pose2{1.0, -0.5, 0.5}, 1e-12, 1e-12));
  const sensor::LaserScan scan = AllOf<sensor::LaserScan>(log).at(0);
  EXPECT_EQ(scan.time, 77'931'000);
  EXPECT_THAT(scan.T_robot_laser, PoseNear(Pose2{0.25, 0.0, 0.0}, 1e-6, 1e-12));
  EXPECT_EQ(scan.ranges[0], 1.5F);
  EXPECT_EQ(sensor::CountBeams(scan).no_returns, 10U);
}

TEST(LogReader, ReadsMinesParisLogsAndIntegratesTheirWheelTicks) {
  const ReadLog log = ReadAll(testing::ProjectData("logs/mines_paris.dat"));
  ASSERT_OK(log.status);
  EXPECT_EQ(log.facts.format, LogFormat::kMinesParis);
  const auto scans = AllOf<sensor::LaserScan>(log);
  ASSERT_EQ(scans.size(), 3U);
  EXPECT_EQ(scans[0].time, 212'387'282'000);
  EXPECT_EQ(scans[0].ranges.size(), 682U);
  EXPECT_NEAR(scans[0].angle(340), 0.0, 1e-12);
  EXPECT_EQ(scans[0].ranges[340], 1.5F);
  EXPECT_EQ(sensor::CountBeams(scans[0]).hits, 241U);
  const auto odometry = AllOf<sensor::Odometry>(log);
  // Both wheels half a turn, then the right one half a turn more: an arc with the radius of half the track.
  const double half_turn = M_PI * 0.077;
  EXPECT_THAT(odometry[1].T_odom_robot, PoseNear(Pose2{half_turn, 0.0, 0.0}, 1e-9, 1e-9));
  EXPECT_NEAR(odometry[2].T_odom_robot.yaw, half_turn / 0.33, 1e-9);
}

TEST(ParseSeconds, IsExact) {
  const auto parsed = [](std::string_view text) {
    TimeNs time = -1;
    EXPECT_TRUE(sources::ParseSeconds(text, time)) << text;
    return time;
  };
  EXPECT_EQ(parsed("976052858.304357"), 976'052'858'304'357'000);
  EXPECT_EQ(parsed("1234567890.123456789"), 1'234'567'890'123'456'789);
  EXPECT_EQ(parsed("0.1234567896"), 123'456'790);
  EXPECT_EQ(parsed("0.9999999999"), 1'000'000'000);
  EXPECT_EQ(parsed("-3.02142"), -3'021'420'000);
  EXPECT_EQ(parsed("+7"), 7'000'000'000);
  EXPECT_EQ(parsed("12."), 12'000'000'000);
  EXPECT_EQ(parsed(".5"), 500'000'000);
  EXPECT_EQ(parsed("9.76e+08"), 976'000'000'000'000'000);
  EXPECT_EQ(parsed("4.85114e-86"), 0);
  EXPECT_EQ(parsed("5.45506e-312"), 0);
  for (const char* text : {"", "-", ".", "1.2.3", "nan", "inf", "1e12", "99999999999", "12s"}) {
    TimeNs time = 0;
    EXPECT_FALSE(sources::ParseSeconds(text, time)) << text;
  }
}

}  // namespace
}  // namespace enfilade::sources
