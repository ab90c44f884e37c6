// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/submap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/compression/compression.h"
#include "core/slam/submaps/robot_rays.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using ::testing::HasSubstr;

// A submap of `scans` keyframes in a room, as the mapper keeps the active one.
SubmapContent RoomContent(int scans) {
  const auto walls = testing::WallsFromText({"########",  //
                                             "#      #",  //
                                             "#   #  #",  //
                                             "#      #",  //
                                             "########"},
                                            1.0);
  SubmapContent content{{}, {}, {}, SubmapGrid(0.05, {})};
  for (int i = 0; i < scans; ++i) {
    const Pose2 pose{2.0 + 0.3 * i, 1.5 + 0.1 * i, 0.2 * i};
    const grid::ScanRays rays = RobotRays(testing::Scan(walls, pose, {}, 0, static_cast<std::uint64_t>(i)), {});
    EXPECT_OK(content.grid.Insert(pose, rays));
    Eigen::Matrix3d information = Eigen::Vector3d(100.0 + i, 50.0, 900.0).asDiagonal();
    information(0, 1) = information(1, 0) = 7.0;
    content.nodes.push_back({10 + i, i < 2, 0.25 * i, pose, information});
    content.scans.push_back(rays);
  }
  content.next = NextSubmap{{3.0, -1.0, 0.5}, 4.0 * Eigen::Matrix3d::Identity()};
  return content;
}

std::string Serialized(const SubmapContent& content) {
  std::string bytes;
  BinaryWriter writer(bytes);
  Serialize(content, writer);
  return bytes;
}

absl::StatusOr<SubmapContent> Deserialized(std::string_view bytes) {
  BinaryReader reader(bytes);
  return DeserializeSubmapContent(reader, {});
}

void ExpectEqualRays(const std::vector<grid::ScanRays>& a, const std::vector<grid::ScanRays>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].origin, b[i].origin);
    EXPECT_EQ(a[i].hits, b[i].hits);
    EXPECT_EQ(a[i].free_ends, b[i].free_ends);
  }
}

TEST(Submap, CountsItsOwnKeyframes) {
  EXPECT_EQ((Submap{0, 0, {}, RoomContent(5)}).own_nodes(), 3) << "the first two are carried";
  EXPECT_EQ((Submap{0, 0, {}, RoomContent(0)}).own_nodes(), 0);
}

TEST(Submap, CountsTheBytesOfGridNodesAndScans) {
  const Submap submap{0, 0, {}, RoomContent(4)};
  Submap without_scans = submap;
  without_scans.content.scans.clear();
  std::size_t points = 0;
  for (const grid::ScanRays& rays : submap.content.scans) points += rays.hits.size() + rays.free_ends.size();
  EXPECT_GE(submap.bytes() - without_scans.bytes(), points * sizeof(Eigen::Vector2d));
  EXPECT_GE(without_scans.bytes(), without_scans.content.grid.bytes() + 4 * sizeof(SubmapNode));
}

TEST(SubmapContentCheckpoint, IsExact) {
  for (const int scans : {0, 1, 5}) {
    SubmapContent content = RoomContent(scans);
    if (scans == 1) content.next.reset();
    ASSERT_OK_AND_ASSIGN(const SubmapContent back, Deserialized(Serialized(content)));
    EXPECT_EQ(back.nodes, content.nodes);
    EXPECT_EQ(back.next, content.next);
    ExpectEqualRays(back.scans, content.scans);
    EXPECT_TRUE(back.grid == content.grid);
    EXPECT_EQ(Serialized(back), Serialized(content));
  }
}

TEST(SubmapContentCheckpoint, RefusesTruncatedBytes) {
  const std::string bytes = Serialized(RoomContent(2));
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 50) {
    EXPECT_CODE(Deserialized(std::string_view(bytes).substr(0, size)), absl::StatusCode::kDataLoss) << size;
  }
}

TEST(SubmapContentCheckpoint, RefusesAnotherVersion) {
  std::string bytes = Serialized(RoomContent(1));
  ++bytes[0];
  EXPECT_STATUS(Deserialized(bytes), absl::StatusCode::kDataLoss, HasSubstr("version"));
}

TEST(SubmapContentCheckpoint, RefusesScansThatDoNotBelongToTheKeyframes) {
  SubmapContent content = RoomContent(3);
  content.scans.pop_back();
  EXPECT_STATUS(Deserialized(Serialized(content)), absl::StatusCode::kDataLoss, HasSubstr("damaged"));
}

TEST(SubmapContentRow, LeavesOutScansAndRoundsHitMeans) {
  const SubmapContent content = RoomContent(5);
  ASSERT_OK_AND_ASSIGN(const SubmapContent back, DecodeSubmapContent(Encode(content), {}));
  EXPECT_EQ(back.nodes, content.nodes);
  EXPECT_EQ(back.next, content.next);
  EXPECT_TRUE(back.scans.empty());
  const auto exact = content.grid.OccupiedPoints();
  const auto rounded = back.grid.OccupiedPoints();
  ASSERT_EQ(rounded.size(), exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_LT((rounded[i] - exact[i]).norm(), 2e-4);
}

TEST(SubmapContentRow, IsTheSameEncodedAgain) {
  const std::string row = Encode(RoomContent(4));
  ASSERT_OK_AND_ASSIGN(const SubmapContent back, DecodeSubmapContent(row, {}));
  EXPECT_EQ(Encode(back), row);
  EXPECT_EQ(Encode(RoomContent(4)), row);
}

TEST(SubmapContentRow, RefusesDamagedBytes) {
  const SubmapContent content = RoomContent(2);
  EXPECT_CODE(DecodeSubmapContent("", {}), absl::StatusCode::kDataLoss);
  EXPECT_CODE(DecodeSubmapContent("not compressed", {}), absl::StatusCode::kDataLoss);
  EXPECT_CODE(DecodeSubmapContent(Compress(""), {}), absl::StatusCode::kDataLoss);
  EXPECT_STATUS(DecodeSubmapContent(Compress(Serialized(content) + "x"), {}), absl::StatusCode::kDataLoss,
                HasSubstr("trailing"));
}

}  // namespace
}  // namespace enfilade::slam
