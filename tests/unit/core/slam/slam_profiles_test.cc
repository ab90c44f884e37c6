// SPDX-License-Identifier: Apache-2.0
#include "core/slam/slam_profiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/status_assertions.h"

namespace enfilade::slam {
namespace {

using ::testing::ElementsAre;

TEST(SlamProfiles, OutdoorSeesFartherThanIndoor) {
  SlamOptions base;
  base.resolution = 0.1;
  const SlamProfiles profiles(base);
  EXPECT_THAT(profiles.Names(), ElementsAre("indoor", "outdoor"));
  const SlamOptions* indoor = profiles.Find(SlamProfiles::kIndoor);
  const SlamOptions* outdoor = profiles.Find(SlamProfiles::kOutdoor);
  ASSERT_NE(indoor, nullptr);
  ASSERT_NE(outdoor, nullptr);
  EXPECT_EQ(indoor->max_range, base.max_range);
  EXPECT_GT(outdoor->max_range, indoor->max_range);
  EXPECT_GT(outdoor->submap.max_keyframes, indoor->submap.max_keyframes);
  EXPECT_EQ(outdoor->resolution, 0.1);
  EXPECT_OK(outdoor->Validate());
}

TEST(SlamProfiles, SetReplacesTheProfileOfThatName) {
  SlamProfiles profiles;
  SlamOptions yard;
  yard.max_range = 80.0;
  profiles.Set("yard", yard);
  profiles.Set("outdoor", yard);
  EXPECT_THAT(profiles.Names(), ElementsAre("indoor", "outdoor", "yard"));
  ASSERT_NE(profiles.Find("indoor"), nullptr);
  EXPECT_EQ(profiles.Find("indoor")->max_range, SlamOptions{}.max_range);
  ASSERT_NE(profiles.Find("yard"), nullptr);
  EXPECT_EQ(profiles.Find("yard")->max_range, 80.0);
  ASSERT_NE(profiles.Find("outdoor"), nullptr);
  EXPECT_EQ(profiles.Find("outdoor")->max_range, 80.0);
  EXPECT_EQ(profiles.Find("hall"), nullptr);
}

}  // namespace
}  // namespace enfilade::slam
