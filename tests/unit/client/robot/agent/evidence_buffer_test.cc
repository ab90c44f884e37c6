// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/evidence_buffer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/sources/content.h"

namespace enfilade::robot {
namespace {

using client::SpoolItem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TimeNs At(double seconds) { return static_cast<TimeNs>(seconds * 1e9); }

SpoolItem ImageAt(double seconds, sensor::Camera camera, sensor::ImageEncoding encoding = sensor::ImageEncoding::kPng) {
  std::string content = std::to_string(seconds) + (camera == sensor::Camera::kFront ? "front" : "rear");
  return {sensor::Image{At(seconds), camera, encoding, sources::RefOf(content)}, content};
}
SpoolItem CloudAt(double seconds) {
  std::string content = std::to_string(seconds) + "cloud";
  return {sensor::PointCloud{At(seconds), sensor::CloudEncoding::kXyz32, sources::RefOf(content)}, content};
}

// "front 1.5", ...
std::vector<std::string> NamesOf(const std::vector<SpoolItem>& items) {
  std::vector<std::string> names;
  for (const SpoolItem& item : items) {
    const auto* image = std::get_if<sensor::Image>(&item.payload);
    const std::string kind = !image ? "cloud" : image->camera == sensor::Camera::kRear ? "rear" : "front";
    names.push_back(kind + " " + std::to_string(TimeOf(item) / 100'000'000));  // tenths
  }
  return names;
}

sensor::DoorReport ReportAt(double seconds, double door_seconds, double door_x) {
  sensor::DoorReport report;
  report.kind = sensor::DoorReport::Kind::kPassage;
  report.time = At(seconds);
  report.door_time = At(door_seconds);
  report.T_odom_door = {door_x, 0.0, 0.0};
  return report;
}

TEST(EvidenceBuffer, GivesWhatIsNearestInTime) {
  EvidenceBuffer buffer({});
  for (int i = 0; i <= 10; ++i) {
    const double t = 0.5 * i;
    buffer.Add(ImageAt(t, sensor::Camera::kFront), {t, 0.0, 0.0});
    buffer.Add(ImageAt(t, sensor::Camera::kRear), {t, 0.0, 0.0});
    buffer.Add(CloudAt(t), {t, 0.0, 0.0});
  }
  EXPECT_THAT(NamesOf(buffer.NearestTo(At(2.1))), ElementsAre("front 20", "rear 20", "cloud 20"));
  EXPECT_THAT(NamesOf(buffer.NearestTo(At(6.9))), ElementsAre("front 50", "rear 50", "cloud 50"));
  EXPECT_THAT(NamesOf(buffer.NearestTo(At(7.1))), IsEmpty()) << "too old";
}

TEST(EvidenceBuffer, SpreadsTheImagesOverTheWayBehindTheDoor) {
  EvidenceOptions options;
  options.images = 3;
  EvidenceBuffer buffer(options);
  for (int i = 0; i <= 10; ++i) {
    buffer.Add(ImageAt(i, sensor::Camera::kFront), {0.5 * i, 0.0, 0.0});
    buffer.Add(CloudAt(i), {0.5 * i, 0.0, 0.0});
  }
  // Through the door at 4 s, reported at 9 s.
  EXPECT_THAT(NamesOf(buffer.BehindDoor(ReportAt(9.0, 4.0, 2.0))),
              ElementsAre("front 50", "front 70", "front 90", "cloud 90"));
}

TEST(EvidenceBuffer, TakesTheCloudFarthestBehindTheDoor) {
  EvidenceBuffer buffer({});
  const double xs[] = {0.0, 1.0, 2.5, 4.0, 2.2};  // and back again
  for (int i = 0; i < 5; ++i) buffer.Add(CloudAt(i), {xs[i], 0.0, 0.0});
  EXPECT_THAT(NamesOf(buffer.BehindDoor(ReportAt(4.0, 1.0, 1.0))), ElementsAre("cloud 30"));
}

TEST(EvidenceBuffer, OfAReportByHandTakesTheLastSeconds) {
  EvidenceBuffer buffer({});
  for (int i = 0; i <= 8; ++i) buffer.Add(ImageAt(i, sensor::Camera::kRear), {0.5 * i, 0.0, 0.0});
  sensor::DoorReport report = ReportAt(8.0, 8.0, 4.0);
  report.by_hand = true;
  EXPECT_THAT(NamesOf(buffer.BehindDoor(report)), ElementsAre("rear 70", "rear 80"));
}

TEST(EvidenceBuffer, KeepsAStandingRobotsNewestOnly) {
  EvidenceBuffer buffer({});
  for (int i = 0; i < 100; ++i) buffer.Add(ImageAt(0.1 * i, sensor::Camera::kFront), {1.0, 0.0, 0.0});
  EXPECT_LE(buffer.size(), 2U);
  EXPECT_THAT(NamesOf(buffer.NearestTo(At(9.9))), ElementsAre("front 99"));
}

TEST(EvidenceBuffer, KeepsTurningsAndForgetsTheOldest) {
  EvidenceOptions options;
  options.kept = 6;
  EvidenceBuffer buffer(options);
  for (int i = 0; i < 20; ++i) buffer.Add(ImageAt(i, sensor::Camera::kFront), {0.0, 0.0, 0.2 * i});
  EXPECT_EQ(buffer.size(), 6U);
  EXPECT_THAT(NamesOf(buffer.NearestTo(At(11.0))), IsEmpty());
}

TEST(EvidenceBuffer, PassesDepthImagesAndLateOnesBy) {
  EvidenceBuffer buffer({});
  buffer.Add(ImageAt(5.0, sensor::Camera::kFront, sensor::ImageEncoding::kDepthPng16), {});
  EXPECT_EQ(buffer.size(), 0U);
  buffer.Add(ImageAt(5.0, sensor::Camera::kFront), {});
  buffer.Add(ImageAt(4.0, sensor::Camera::kFront), {1.0, 0.0, 0.0});
  EXPECT_EQ(buffer.size(), 1U);
}

TEST(MergedByTime, GivesEachThingOnceInTheOrderOfTime) {
  const std::vector<SpoolItem> a = {ImageAt(2.0, sensor::Camera::kFront), CloudAt(3.0)};
  const std::vector<SpoolItem> b = {ImageAt(1.0, sensor::Camera::kFront), ImageAt(2.0, sensor::Camera::kFront)};
  EXPECT_THAT(NamesOf(MergedByTime(a, b)), ElementsAre("front 10", "front 20", "cloud 30"));
}

}  // namespace
}  // namespace enfilade::robot
