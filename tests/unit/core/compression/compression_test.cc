// SPDX-License-Identifier: Apache-2.0
#include "core/compression/compression.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/support/status_assertions.h"

namespace enfilade {
namespace {

using ::testing::HasSubstr;

std::string RandomBytes(std::size_t size, int values, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> any(0, values - 1);
  std::string bytes(size, '\0');
  for (char& c : bytes) c = static_cast<char>(any(random));
  return bytes;
}

TEST(Compression, GivesBackWhatWasCompressed) {
  for (const std::size_t size : {0UL, 1UL, 3UL, 255UL, 4096UL, 300'000UL}) {
    for (const int values : {1, 3, 256}) {
      const std::string bytes = RandomBytes(size, values, 5);
      ASSERT_OK_AND_ASSIGN(const std::string back, Decompress(Compress(bytes), size));
      EXPECT_EQ(back, bytes) << size << " bytes of " << values << " values";
    }
  }
}

TEST(Compression, IsDeterministicAndMakesRepetitionSmall) {
  const std::string bytes(100'000, 'w');
  EXPECT_EQ(Compress(bytes), Compress(bytes));
  EXPECT_LT(Compress(bytes).size(), 200U);
}

TEST(Compression, RefusesMoreThanTheLimit) {
  const std::string compressed = Compress(std::string(1'000, 'a'));
  EXPECT_OK(Decompress(compressed, 1'000));
  EXPECT_STATUS(Decompress(compressed, 999), absl::StatusCode::kDataLoss, HasSubstr("at most 999 bytes"));
}

TEST(Compression, RefusesTruncatedBytesAtEveryLength) {
  const std::string compressed = Compress(RandomBytes(2'000, 16, 7));
  for (std::size_t size = 0; size < compressed.size(); ++size) {
    EXPECT_CODE(Decompress(std::string_view(compressed).substr(0, size), 2'000), absl::StatusCode::kDataLoss) << size;
  }
}

TEST(Compression, RefusesBytesThatAreNotCompressed) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    EXPECT_CODE(Decompress(RandomBytes(64, 256, seed), 1'000'000), absl::StatusCode::kDataLoss) << "seed " << seed;
  }
}

}  // namespace
}  // namespace enfilade
