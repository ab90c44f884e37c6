// SPDX-License-Identifier: Apache-2.0
#include "core/base/binary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace enfilade {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(BinaryWriter, WritesLittleEndian) {
  std::string bytes;
  BinaryWriter writer(bytes);
  writer.Put<std::uint8_t>(1);
  writer.Put<std::uint16_t>(0x0203);
  writer.Put<std::int32_t>(-2);
  writer.PutString("ab");
  EXPECT_EQ(bytes, std::string("\x01\x03\x02\xfe\xff\xff\xff\x02\0\0\0\0\0\0\0ab", 17));
}

TEST(BinaryWriter, AppendsToExistingBytes) {
  std::string bytes = "head";
  BinaryWriter(bytes).Put<char>('!');
  EXPECT_EQ(bytes, "head!");
}

// One value of each kind, drawn at random; written and read in a random order.
struct RandomValues {
  std::vector<int> kinds;
  std::vector<double> doubles;
  std::vector<std::int64_t> integers;
  std::vector<std::string> strings;
  std::vector<std::vector<float>> vectors;

  explicit RandomValues(unsigned seed) {
    std::mt19937_64 random(seed);
    for (int i = 0; i < 50; ++i) {
      kinds.push_back(static_cast<int>(random() % 4));
      std::uint64_t bits = random();
      double value = 0.0;
      std::memcpy(&value, &bits, sizeof value);
      doubles.push_back(value);  // any bit pattern, NaN included
      integers.push_back(static_cast<std::int64_t>(random()));
      strings.emplace_back(random() % 20, static_cast<char>(random() % 256));
      vectors.emplace_back(random() % 5, static_cast<float>(random() % 1000) / 7.0F);
    }
  }

  std::string Write() const {
    std::string bytes;
    BinaryWriter writer(bytes);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (kinds[i] == 0) writer.Put(doubles[i]);
      if (kinds[i] == 1) writer.Put(integers[i]);
      if (kinds[i] == 2) writer.PutString(strings[i]);
      if (kinds[i] == 3) writer.PutVector(vectors[i]);
    }
    return bytes;
  }

  // False at the first difference.
  bool Matches(BinaryReader& reader) const {
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (kinds[i] == 0) {
        const auto value = reader.Get<double>();
        if (std::memcmp(&value, &doubles[i], sizeof value) != 0) return false;
      }
      if (kinds[i] == 1 && reader.Get<std::int64_t>() != integers[i]) return false;
      if (kinds[i] == 2 && reader.GetString() != strings[i]) return false;
      if (kinds[i] == 3 && reader.GetVector<float>() != vectors[i]) return false;
    }
    return true;
  }
};

class BinaryRoundTrip : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, BinaryRoundTrip, ::testing::Range(1U, 21U));

TEST_P(BinaryRoundTrip, RestoresEveryBit) {
  const RandomValues values(GetParam());
  const std::string bytes = values.Write();
  BinaryReader reader(bytes);
  EXPECT_TRUE(values.Matches(reader));
  EXPECT_TRUE(reader.at_end());
}

TEST_P(BinaryRoundTrip, FailsForEveryTruncation) {
  const RandomValues values(GetParam());
  const std::string bytes = values.Write();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    BinaryReader reader(std::string_view(bytes).substr(0, size));
    EXPECT_FALSE(values.Matches(reader) && reader.at_end()) << size;
  }
}

TEST(BinaryReader, StaysFailedAndReturnsZeros) {
  BinaryReader reader("abc");
  EXPECT_EQ(reader.Get<std::int32_t>(), 0);
  EXPECT_FALSE(reader.ok());
  EXPECT_EQ(reader.Get<char>(), '\0') << "although three bytes remain";
  EXPECT_THAT(reader.GetBytes(1), IsEmpty());
  EXPECT_THAT(reader.GetString(), IsEmpty());
  EXPECT_THAT(reader.GetVector<int>(), IsEmpty());
  EXPECT_FALSE(reader.at_end());
}

TEST(BinaryReader, RefusesLengthsBeyondTheBytesBeforeAllocating) {
  for (const std::uint64_t length : {std::uint64_t{3}, std::uint64_t{1} << 61, ~std::uint64_t{0}}) {
    std::string bytes;
    BinaryWriter writer(bytes);
    writer.Put(length);
    writer.PutBytes("12345678");
    BinaryReader of_doubles(bytes);
    EXPECT_THAT(of_doubles.GetVector<double>(), IsEmpty()) << length;
    EXPECT_FALSE(of_doubles.ok());
    BinaryReader of_text(bytes);
    EXPECT_EQ(of_text.GetString(), length == 3 ? "123" : "");
    EXPECT_EQ(of_text.ok(), length == 3);
  }
}

TEST(BinaryReader, ReadsAnyByteAsABool) {
  BinaryReader reader(std::string_view("\x00\x01\x02\xff", 4));
  std::vector<int> values;
  for (int i = 0; i < 4; ++i) values.push_back(reader.Get<bool>() ? 1 : 0);
  EXPECT_THAT(values, ElementsAre(0, 1, 1, 1));
}

TEST(BinaryReader, CountsTheRemainingBytes) {
  BinaryReader reader("abcdef");
  EXPECT_EQ(reader.GetBytes(2), "ab");
  EXPECT_EQ(reader.remaining(), 4U);
  EXPECT_FALSE(reader.at_end());
  EXPECT_EQ(reader.GetBytes(4), "cdef");
  EXPECT_TRUE(reader.at_end());
}

}  // namespace
}  // namespace enfilade
