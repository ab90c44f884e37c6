// SPDX-License-Identifier: Apache-2.0
// Cloud files that are damaged or made to do harm, and LZF against a plain compressor.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "perception/cloud/decode_cloud.h"
#include "perception/cloud/lzf.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/perception/cloud/rooms.h"

namespace enfilade::perception {
namespace {

using ::testing::HasSubstr;

// LZF with literal runs and the longest reference within reach: slow, but by the format's definition.
std::string PackLzf(const std::string& bytes) {
  std::string packed;
  std::string literals;
  const auto flush = [&] {
    for (std::size_t i = 0; i < literals.size(); i += 32) {
      const std::string run = literals.substr(i, 32);
      packed += static_cast<char>(run.size() - 1);
      packed += run;
    }
    literals.clear();
  };
  for (std::size_t at = 0; at < bytes.size();) {
    std::size_t best = 0;
    std::size_t distance = 0;
    for (std::size_t back = 1; back <= std::min<std::size_t>(at, 300); ++back) {
      std::size_t length = 0;
      while (length < 264 && at + length < bytes.size() && bytes[at + length] == bytes[at + length - back]) ++length;
      if (length > best) {
        best = length;
        distance = back;
      }
    }
    if (best < 3) {
      literals += bytes[at++];
      continue;
    }
    flush();
    const std::size_t length = best - 2;
    const std::size_t offset = distance - 1;
    packed += static_cast<char>(std::min<std::size_t>(length, 7) << 5 | offset >> 8);
    if (length >= 7) packed += static_cast<char>(length - 7);
    packed += static_cast<char>(offset & 255);
    at += best;
  }
  flush();
  return packed;
}

class CloudSeeds : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Clouds, CloudSeeds, ::testing::Range(1U, 21U));

TEST_P(CloudSeeds, LzfUnpacksWhatWasPacked) {
  std::mt19937 random(GetParam());
  std::string bytes;
  while (bytes.size() < 2000) bytes.append(1 + random() % 400, static_cast<char>('a' + random() % 3));
  for (std::uint32_t noise = random() % 300; noise > 0; --noise)
    bytes[random() % bytes.size()] = static_cast<char>(random());
  const std::string packed = PackLzf(bytes);
  ASSERT_OK_AND_ASSIGN(const std::string unpacked, UnpackLzf(packed, bytes.size()));
  EXPECT_EQ(unpacked, bytes);
  EXPECT_CODE(UnpackLzf(packed, bytes.size() - 1), absl::StatusCode::kDataLoss);
  EXPECT_CODE(UnpackLzf(packed, bytes.size() + 1), absl::StatusCode::kDataLoss);
  for (int trial = 0; trial < 200; ++trial) {
    std::string damaged = packed;
    damaged[random() % damaged.size()] = static_cast<char>(random());
    const auto result = UnpackLzf(damaged, bytes.size());
    if (result.ok()) {
      EXPECT_EQ(result->size(), bytes.size());
    }
  }
}

std::string CompressedPcd(const Cloud& cloud) {
  std::string columns;
  for (int k = 0; k < 3; ++k) {
    for (const Eigen::Vector3f& point : cloud.points) columns.append(reinterpret_cast<const char*>(&point[k]), 4);
  }
  const std::string packed = PackLzf(columns);
  std::string bytes = fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\n"
      "POINTS {0}\nDATA binary_compressed\n",
      cloud.points.size());
  for (const std::size_t size : {packed.size(), columns.size()}) {
    const auto word = static_cast<std::uint32_t>(size);
    bytes.append(reinterpret_cast<const char*>(&word), 4);
  }
  return bytes + packed;
}

std::string TextOf(const Cloud& cloud, bool ply) {
  std::string text = ply ? fmt::format(
                               "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
                               "property float z\nend_header\n",
                               cloud.points.size())
                         : fmt::format(
                               "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
                               "WIDTH {0}\nHEIGHT 1\nPOINTS {0}\nDATA ascii\n",
                               cloud.points.size());
  for (const Eigen::Vector3f& point : cloud.points) {
    text += fmt::format("{} {} {}\n", point.x(), point.y(), point.z());
  }
  return text;
}

std::string BinaryPly(const Cloud& cloud) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double z\nproperty uchar intensity\n"
      "property float x\nproperty float y\nend_header\n",
      cloud.points.size());
  for (const Eigen::Vector3f& point : cloud.points) {
    const double z = point.z();
    bytes.append(reinterpret_cast<const char*>(&z), 8);
    bytes += '\x07';
    bytes.append(reinterpret_cast<const char*>(point.data()), 8);
  }
  return bytes;
}

std::vector<std::string> EveryFormat(const Cloud& cloud) {
  return {testing::EncodePcd(cloud), CompressedPcd(cloud), TextOf(cloud, false), TextOf(cloud, true), BinaryPly(cloud)};
}

TEST_P(CloudSeeds, EveryFormatGivesTheSamePoints) {
  const Cloud cloud = testing::Room(GetParam(), GetParam() + 1, 0.01, 60);
  for (const std::string& bytes : EveryFormat(cloud)) {
    ASSERT_OK_AND_ASSIGN(const Cloud decoded, DecodeCloud(bytes));
    EXPECT_EQ(decoded.points, cloud.points) << bytes.substr(0, 40);
  }
  std::string raw;
  for (const Eigen::Vector3f& point : cloud.points) raw.append(reinterpret_cast<const char*>(point.data()), 12);
  ASSERT_OK_AND_ASSIGN(const Cloud bare, DecodeXyz32(raw));
  EXPECT_EQ(bare.points, cloud.points);
}

// Whatever is changed in a file: an error, or a cloud of at most as many points as fit into the file.
TEST_P(CloudSeeds, MutatedFilesAreHarmless) {
  std::mt19937 random(GetParam() + 100);
  const Cloud cloud = testing::Room(GetParam(), GetParam() + 1, 0.01, 20);
  for (const std::string& bytes : EveryFormat(cloud)) {
    for (int trial = 0; trial < 200; ++trial) {
      std::string damaged = bytes;
      for (std::uint32_t changes = 1 + random() % 3; changes > 0; --changes) {
        const std::size_t at = random() % damaged.size();
        if (random() % 3 == 0) {
          damaged.insert(at, 1 + random() % 5, "0123456789 \n"[random() % 12]);
        } else if (random() % 3 == 0 && damaged.size() > 20) {
          damaged.erase(at, 1 + random() % 10);
        } else {
          damaged[at] = static_cast<char>(random());
        }
      }
      const auto result = DecodeCloud(damaged);
      if (result.ok()) {
        EXPECT_LE(result->points.size(), damaged.size());
      } else {
        EXPECT_CODE(result, absl::StatusCode::kInvalidArgument);
      }
    }
  }
}

TEST(HostileClouds, HeadersCannotOverflowTheSize) {
  // 2^22 points of 2^42 + 12 bytes: their product is far beyond 2^64.
  std::string fields = "FIELDS x y z";
  std::string sizes = "SIZE 4 4 4";
  std::string types = "TYPE F F F";
  std::string counts = "COUNT 1 1 1";
  for (int i = 0; i < 1024; ++i) {
    fields += " _";
    sizes += " 65536";
    types += " U";
    counts += " 65536";
  }
  for (const char* data : {"binary", "binary_compressed"}) {
    const std::string header = "VERSION .7\n" + fields + "\n" + sizes + "\n" + types + "\n" + counts +
                               "\nWIDTH 4194304\nHEIGHT 1\nDATA " + data + "\n";
    EXPECT_STATUS(DecodeCloud(header + std::string(1000, '\0')), absl::StatusCode::kInvalidArgument,
                  HasSubstr("a point of"));
  }
}

TEST(HostileClouds, AnnouncedSizesAreNotBelieved) {
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  const std::string xyz = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
  EXPECT_STATUS(DecodeCloud(xyz + "POINTS 6000000\nDATA binary\n123"), kBad, HasSubstr("truncated"));
  EXPECT_STATUS(DecodeCloud(xyz + "POINTS 6000000\nDATA ascii\n1 2 3\n"), kBad, HasSubstr("ends after 1"));
  std::string compressed = xyz + "POINTS 6000000\nDATA binary_compressed\n";
  compressed += std::string("\x02\0\0\0", 4);        // packed bytes
  compressed += std::string("\x00\xA2\x4A\x04", 4);  // 72,000,000 unpacked bytes
  compressed += std::string("\x00z", 2);
  EXPECT_STATUS(DecodeCloud(compressed), kBad, HasSubstr("1 bytes instead of 72000000"));
  EXPECT_STATUS(DecodeCloud("ply\nformat ascii 1.0\nelement vertex 6000001\n"), kBad, HasSubstr("up to 6000000"));
  EXPECT_STATUS(DecodeCloud("ply\nformat ascii 1.0\nelement face 3\n"), kBad, HasSubstr("precedes the vertices"));
  EXPECT_STATUS(
      DecodeCloud("ply\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n"), kBad,
      HasSubstr("no format"));
  EXPECT_STATUS(DecodeCloud("ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar float x\nend_header\n"), kBad,
                HasSubstr("expected a number"));
  EXPECT_STATUS(DecodeCloud(xyz + "COUNT 1 1 0\n"), kBad, HasSubstr("COUNT 0"));
  EXPECT_STATUS(DecodeCloud(xyz + "COUNT 1 1\n"), kBad, HasSubstr("2 COUNT for 3 fields"));
  EXPECT_STATUS(DecodeCloud("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F X\n"), kBad, HasSubstr("TYPE X"));
  EXPECT_STATUS(DecodeCloud("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F U\nPOINTS 0\nDATA ascii\n"), kBad,
                HasSubstr("field z"));
}

}  // namespace
}  // namespace enfilade::perception
