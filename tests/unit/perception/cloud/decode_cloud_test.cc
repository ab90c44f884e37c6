// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/decode_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "perception/cloud/lzf.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/perception/cloud/rooms.h"

namespace enfilade::perception {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename T>
void Append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

TEST(DecodeCloudTest, ReadsBinaryPcd) {
  const Cloud room = testing::Room(1, 2, 0.01, 500);
  ASSERT_OK_AND_ASSIGN(const Cloud decoded, DecodeCloud(testing::EncodePcd(room)));
  EXPECT_EQ(decoded.points, room.points);
  ASSERT_OK_AND_ASSIGN(const Cloud empty, DecodeCloud(testing::EncodePcd({})));
  EXPECT_TRUE(empty.points.empty());
}

TEST(DecodeCloudTest, ReadsTextWithOtherFieldsAndNan) {
  ASSERT_OK_AND_ASSIGN(const Cloud cloud,
                       DecodeCloud("VERSION .7\nFIELDS intensity normal y x z\nSIZE 4 4 4 4 8\nTYPE U F F F F\n"
                                   "COUNT 1 3 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n"
                                   "7 0 0 1 2 1 3\n\n7 0 0 1 +2.5e0 nan -inf\n"));
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  EXPECT_TRUE(std::isnan(cloud.points[1].x()));
  EXPECT_EQ(cloud.points[1].y(), 2.5F);
  EXPECT_TRUE(FinitePoints(cloud).points.size() == 1);
}

// Columns: all x as double, all flags, all y, all z; packed as literal runs and one reference.
TEST(DecodeCloudTest, ReadsPackedColumns) {
  std::string columns;
  for (const double x : {1.0, 1.0}) Append(columns, x);
  columns += "ab";
  for (const float value : {3.0F, 4.0F, 5.0F, 6.0F}) Append(columns, value);
  std::string packed("\x07", 1);
  packed += columns.substr(0, 8);
  packed += std::string("\xC0\x07", 2);  // 8 bytes from 8 before
  packed += std::string("\x11", 1) + columns.substr(16);
  std::string bytes =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x flag y z\nSIZE 8 1 4 4\nTYPE F U F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
      "POINTS 2\nDATA binary_compressed\n";
  Append(bytes, static_cast<std::uint32_t>(packed.size()));
  Append(bytes, static_cast<std::uint32_t>(columns.size()));
  bytes += packed;
  ASSERT_OK_AND_ASSIGN(const Cloud cloud, DecodeCloud(bytes));
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3f(1, 3, 5), Eigen::Vector3f(1, 4, 6)));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_CODE(DecodeCloud(std::string_view(bytes).substr(0, size)), absl::StatusCode::kInvalidArgument);
  }
}

TEST(DecodeCloudTest, ReadsPly) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment made here\nelement vertex 2\nproperty uchar red\n"
      "property float x\nproperty double y\nproperty float z\nelement face 0\nproperty list uchar int "
      "index\nend_header\n";
  for (int i = 0; i < 2; ++i) {
    bytes += "r";
    Append(bytes, 1.0F + static_cast<float>(i));
    Append(bytes, 2.0);
    Append(bytes, 3.0F);
  }
  ASSERT_OK_AND_ASSIGN(const Cloud cloud, DecodeCloud(bytes));
  EXPECT_THAT(cloud.points, ElementsAre(Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(2, 2, 3)));
  bytes.pop_back();
  EXPECT_STATUS(DecodeCloud(bytes), absl::StatusCode::kInvalidArgument, HasSubstr("truncated"));
  ASSERT_OK_AND_ASSIGN(const Cloud text,
                       DecodeCloud("ply\r\nformat ascii 1.0\r\nelement vertex 1\r\nproperty float x\r\n"
                                   "property float y\r\nproperty float z\r\nend_header\r\n1 2 3\r\n"));
  EXPECT_THAT(text.points, ElementsAre(Eigen::Vector3f(1, 2, 3)));
}

TEST(DecodeCloudTest, NamesTheFault) {
  const auto pcd = [](const std::string& header) { return DecodeCloud("VERSION .7\n" + header); };
  const std::string xyz = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_STATUS(DecodeCloud(""), kBad, HasSubstr("0 bytes"));
  EXPECT_STATUS(DecodeCloud("x,y,z\n1,2,3\n"), kBad, HasSubstr("neither PCD nor PLY"));
  EXPECT_STATUS(pcd(xyz), kBad, HasSubstr("no DATA line"));
  EXPECT_STATUS(pcd(xyz + "WIDTH 2\nDATA ascii\n1 2 3\n"), kBad, HasSubstr("ends after 1 of 2"));
  EXPECT_STATUS(pcd(xyz + "WIDTH 1\nDATA ascii\n1 two 3\n"), kBad, HasSubstr("1 two 3"));
  EXPECT_STATUS(pcd(xyz + "WIDTH 99999999999\nDATA binary\n"), kBad, HasSubstr("expected a number"));
  EXPECT_STATUS(pcd(xyz + "WIDTH 6000000\nHEIGHT 6000000\nDATA binary\n"), kBad, HasSubstr("more than the limit"));
  EXPECT_STATUS(pcd("FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 1\nDATA binary\n12345678"), kBad, HasSubstr("no field z"));
  EXPECT_STATUS(pcd("FIELDS x y z\nSIZE 4 4\nDATA binary\n"), kBad, HasSubstr("SIZE"));
  EXPECT_STATUS(pcd("FIELDS x y z\nSIZE 2 2 2\nTYPE F F F\nWIDTH 0\nDATA binary\n"), kBad,
                HasSubstr("no single float"));
  EXPECT_STATUS(pcd(xyz + "WIDTH 1\nDATA lzma\n"), kBad, HasSubstr("lzma"));
  EXPECT_STATUS(DecodeCloud("ply\nformat binary_big_endian 1.0\n"), kBad, HasSubstr("big_endian"));
  EXPECT_STATUS(DecodeXyz32("1234567"), kBad, HasSubstr("7 bytes"));
}

TEST(LzfTest, RefusesReferencesBeforeTheBeginning) {
  EXPECT_CODE(UnpackLzf(std::string("\x20\x05", 2), 3), absl::StatusCode::kDataLoss);
  EXPECT_CODE(UnpackLzf(std::string("\x00z\xE0\xFF\x00", 5), 3), absl::StatusCode::kDataLoss);
  EXPECT_CODE(UnpackLzf(std::string("\x20\x00", 2), 3), absl::StatusCode::kDataLoss) << "one byte before the start";
  EXPECT_CODE(UnpackLzf(std::string("\x00z\x20\x01", 4), 4), absl::StatusCode::kDataLoss)
      << "one byte before the start";
  ASSERT_OK_AND_ASSIGN(const std::string run, UnpackLzf(std::string("\x00z\x20\x00", 4), 4));
  EXPECT_EQ(run, "zzzz");
}

TEST(CloudTest, ThinsToOnePointAVoxel) {
  const Cloud cloud{{{0.1F, 0.1F, 0.1F}, {0.3F, 0.1F, 0.1F}, {-0.1F, 0.1F, 0.1F}, {NAN, 0.0F, 0.0F}}};
  ASSERT_OK_AND_ASSIGN(const Cloud thinned, VoxelFilter(cloud, 0.5));
  ASSERT_EQ(thinned.points.size(), 2U);
  EXPECT_EQ(thinned.points[0], Eigen::Vector3f(-0.1F, 0.1F, 0.1F));
  EXPECT_NEAR(thinned.points[1].x(), 0.2F, 1e-6F);
  EXPECT_STATUS(VoxelFilter(cloud, -1.0), absl::StatusCode::kInvalidArgument, HasSubstr("voxel"));
}

}  // namespace
}  // namespace enfilade::perception
