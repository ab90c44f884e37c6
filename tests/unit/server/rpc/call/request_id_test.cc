// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/request_id.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>
#include <vector>

namespace enfilade::server {
namespace {

TEST(RequestId, TakesTheUsualForms) {
  for (const std::string id :
       {"1", "550e8400-e29b-41d4-a716-446655440000", "01ARZ3NDEKTSV4RRFFQ69G5FAV",
        "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01", "robot-1/stream:4", "bXkgaWQ+/w=="}) {
    EXPECT_TRUE(IsValidRequestId(id)) << id;
    EXPECT_EQ(RequestIdOrNew(id), id);
  }
  EXPECT_TRUE(IsValidRequestId(std::string(128, 'a')));
}

TEST(RequestId, ReplacesWhatDoesNotBelongIntoALogOrMetadata) {
  for (const std::string& id :
       {std::string(), std::string("a b"), std::string("a\nb"), std::string("a\0b", 3), std::string("\"a\""),
        std::string("a%20b"), std::string("\xC3\xA9"), std::string("{id}"), std::string(129, 'a')}) {
    EXPECT_FALSE(IsValidRequestId(id)) << id;
    const std::string replacement = RequestIdOrNew(id);
    EXPECT_NE(replacement, id);
    EXPECT_TRUE(IsValidRequestId(replacement)) << replacement;
  }
}

TEST(RequestId, NewOnesDifferInAllThreads) {
  constexpr int kThreads = 4;
  constexpr int kIds = 500;
  std::vector<std::vector<std::string>> made(kThreads);
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (auto& ids : made) {
    threads.emplace_back([&ids] {
      for (int i = 0; i < kIds; ++i) ids.push_back(NewRequestId());
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::set<std::string> all;
  for (const auto& ids : made) all.insert(ids.begin(), ids.end());
  EXPECT_EQ(all.size(), std::size_t{kThreads} * kIds);
  for (const std::string& id : all) {
    EXPECT_EQ(id.size(), 16U);
    EXPECT_EQ(id.find_first_not_of("0123456789abcdef"), std::string::npos) << id;
  }
}

}  // namespace
}  // namespace enfilade::server
