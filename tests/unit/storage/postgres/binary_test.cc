// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "storage/postgres/driver/copy_buffer.h"
#include "storage/postgres/driver/params.h"
#include "storage/postgres/driver/types.h"

namespace enfilade::storage::postgres {
namespace {

std::string Hex(std::string_view bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const char byte : bytes) {
    text += kDigits[static_cast<unsigned char>(byte) >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::string HexOfParam(const Params& params, std::size_t i) {
  const Params::Bound bound = params.Bind();
  return Hex({bound.values[i], static_cast<std::size_t>(bound.lengths[i])});
}

TEST(BinaryTest, NumbersAreBigEndian) {
  const Params params(true, std::int16_t{-2}, std::int32_t{0x01020304}, std::int64_t{0x0102030405060708}, 1.5);
  EXPECT_EQ(HexOfParam(params, 0), "01");
  EXPECT_EQ(HexOfParam(params, 1), "fffe");
  EXPECT_EQ(HexOfParam(params, 2), "01020304");
  EXPECT_EQ(HexOfParam(params, 3), "0102030405060708");
  EXPECT_EQ(HexOfParam(params, 4), "3ff8000000000000");
}

TEST(BinaryTest, DecodesWhatWasEncoded) {
  for (const double value : {0.1, -0.0, std::numeric_limits<double>::denorm_min(), -1e308}) {
    std::string bytes;
    AppendBinary(value, bytes);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(DecodeBinary<double>(bytes.data())), std::bit_cast<std::uint64_t>(value));
  }
  for (const std::int64_t value : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::int64_t{1} << 40}) {
    std::string bytes;
    AppendBinary(value, bytes);
    EXPECT_EQ(DecodeBinary<std::int64_t>(bytes.data()), value);
  }
}

TEST(BinaryTest, TimestampsCountMicrosecondsFromTheYear2000) {
  constexpr TimeNs k2000 = 946'684'800LL * kNsPerSecond;
  EXPECT_EQ(TimestampFromTime(k2000), 0);
  EXPECT_EQ(TimestampFromTime(k2000 + 1'999), 1);
  EXPECT_EQ(TimeFromTimestamp(1), k2000 + 1'000);
}

TEST(BinaryTest, NullAndEmptyAreDifferent) {
  const Params params(std::optional<std::int64_t>(), std::string_view(), std::optional<std::string_view>(""));
  const Params::Bound bound = params.Bind();
  EXPECT_EQ(bound.values[0], nullptr);
  EXPECT_EQ(bound.types[0], 20U);
  EXPECT_NE(bound.values[1], nullptr);
  EXPECT_EQ(bound.lengths[1], 0);
  EXPECT_NE(bound.values[2], nullptr);
}

TEST(BinaryTest, ArraysCarryTheirElementsType) {
  const Params params(std::vector<std::int16_t>{1, 2}, std::vector<Bytes>{}, std::vector<std::string_view>{"ab"});
  EXPECT_EQ(HexOfParam(params, 0),
            "00000001"
            "00000000"
            "00000015"
            "00000002"
            "00000001"
            "00000002"
            "0001"
            "00000002"
            "0002");
  EXPECT_EQ(HexOfParam(params, 1),
            "00000000"
            "00000000"
            "00000011");
  EXPECT_EQ(HexOfParam(params, 2),
            "00000001"
            "00000000"
            "00000019"
            "00000001"
            "00000001"
            "00000002"
            "6162");
}

// Many values make the buffer grow: what was bound before must not be left behind.
TEST(BinaryTest, PointersHoldAfterTheLastValue) {
  Params params;
  for (std::int64_t i = 0; i < 1000; ++i) params.Add(i);
  const Params::Bound bound = params.Bind();
  for (std::size_t i = 0; i < 1000; ++i) {
    EXPECT_EQ(DecodeBinary<std::int64_t>(bound.values[i]), static_cast<std::int64_t>(i));
  }
}

TEST(CopyBufferTest, WritesTheBinaryFormatOfCopy) {
  CopyBuffer buffer;
  buffer.BeginRow(3);
  buffer.Put(std::int16_t{7});
  buffer.Put("ab");
  EXPECT_EQ(buffer.PutAppended([](std::string& out) { out += "xyz"; }), 3U);
  EXPECT_EQ(Hex(buffer.Finish()),
            "5047434f50590aff0d0a00"
            "00000000"
            "00000000"
            "0003"
            "00000002"
            "0007"
            "00000002"
            "6162"
            "00000003"
            "78797a"
            "ffff");
}

}  // namespace
}  // namespace enfilade::storage::postgres
