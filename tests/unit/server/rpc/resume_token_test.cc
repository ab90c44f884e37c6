// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "server/rpc/graph/watch_global_poses.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

TEST(ResumeToken, GivesThePositionBack) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  for (const PoseUpdates::Position& position :
       {PoseUpdates::Position{0, 0}, PoseUpdates::Position{17, 4}, PoseUpdates::Position{kMost, kMost}}) {
    ASSERT_OK_AND_ASSIGN(const PoseUpdates::Position back, FromResumeToken(ToResumeToken(position)));
    EXPECT_EQ(back, position);
  }
  EXPECT_EQ(*FromResumeToken(""), PoseUpdates::Position());
}

TEST(ResumeToken, RefusesOtherTexts) {
  for (const std::string token :
       {"1", "-", "1-", "-1", "1-2-3", "1-2 ", " 1-2", "a-b", "1_2", "99999999999999999999-1"}) {
    EXPECT_STATUS(FromResumeToken(token), absl::StatusCode::kInvalidArgument, ::testing::HasSubstr("resume_token"))
        << token;
  }
  EXPECT_LT(FromResumeToken(std::string(10'000, 'x')).status().message().size(), 200U);
}

}  // namespace
}  // namespace enfilade::server
