// SPDX-License-Identifier: Apache-2.0
#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace enfilade {
namespace {

TEST(ForEachIndex, CallsOnceWithEachIndex) {
  for (const int threads : {-1, 1, 3, 50}) {
    std::vector<int> calls(20, 0);
    ForEachIndex(calls.size(), threads, [&](std::size_t i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(20, 1)) << threads;
  }
}

TEST(ForEachIndex, WorksOnSeveralThreadsAtOnce) {
  std::atomic<int> present = 0;
  ForEachIndex(3, 3, [&](std::size_t) {
    ++present;
    while (present < 3) {  // none leaves before all have come
    }
  });
  EXPECT_EQ(present, 3);
}

TEST(ForEachIndex, CallsNothingWithoutIndices) {
  ForEachIndex(0, 4, [](std::size_t) { FAIL(); });
}

TEST(ForEachIndex, ThrowsWhatACallThrows) {
  for (const int threads : {1, 4}) {
    const auto fail = [](std::size_t i) {
      if (i == 7) throw std::out_of_range("seven");
    };
    EXPECT_THROW(ForEachIndex(10, threads, fail), std::out_of_range);
  }
}

}  // namespace
}  // namespace enfilade
