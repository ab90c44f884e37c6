// SPDX-License-Identifier: Apache-2.0
#include "core/base/ids.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <unordered_set>

#include "core/base/resource_name.h"
#include "core/base/time.h"
#include "core/base/uuid.h"

namespace enfilade {
namespace {

TEST(ResourceId, AcceptsAip122Ids) {
  for (const char* id : {"a", "0", "site-1", "a--b", "123", "0123456789abcdef-0123456789abcdef"}) {
    EXPECT_TRUE(IsValidResourceId(id)) << id;
  }
  EXPECT_TRUE(IsValidResourceId(std::string(63, 'x')));
}

TEST(ResourceId, RefusesEverythingElse) {
  for (const char* id : {"", "-", "-a", "a-", "A", "aB", "a_b", "a.b", "a/b", "a b", " a", "a\n", "\xc3\xa4", "a+"}) {
    EXPECT_FALSE(IsValidResourceId(id)) << id;
  }
  EXPECT_FALSE(IsValidResourceId(std::string(64, 'x')));
  EXPECT_FALSE(IsValidResourceId(std::string_view("a\0b", 3)));
}

TEST(ResourceName, FollowsTheApi) {
  const SiteId site("hq");
  EXPECT_EQ(NameOf(site), "sites/hq");
  EXPECT_EQ(NameOf(site, RobotId("r1")), "sites/hq/robots/r1");
  EXPECT_EQ(NameOf(site, MapId("m1")), "sites/hq/maps/m1");
  EXPECT_EQ(NameOf(site, LinkPointId("l1")), "sites/hq/linkPoints/l1");
  EXPECT_EQ(NameOf(site, SessionId("s1")), "sites/hq/sessions/s1");
}

TEST(Id, ComparesAndHashesByValue) {
  EXPECT_TRUE(MapId().empty());
  EXPECT_LT(MapId("a"), MapId("b"));
  EXPECT_EQ(MapId("a"), MapId(std::string("a")));
  const std::unordered_set<MapId> ids = {MapId("a"), MapId("b"), MapId("a")};
  EXPECT_EQ(ids.size(), 2U);
}

TEST(NewUuid, IsAValidRandomResourceId) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string uuid = NewUuid();
    ASSERT_EQ(uuid.size(), 36U);
    EXPECT_TRUE(IsValidResourceId(uuid)) << uuid;
    EXPECT_EQ(uuid[14], '4') << "version 4: " << uuid;
    EXPECT_NE(std::string("89ab").find(uuid[19]), std::string::npos) << "RFC 9562's variant: " << uuid;
    for (const std::size_t dash : {8U, 13U, 18U, 23U}) EXPECT_EQ(uuid[dash], '-');
    EXPECT_TRUE(seen.insert(uuid).second) << uuid;
  }
}

TEST(Time, ConvertsSeconds) {
  EXPECT_EQ(DurationOf(1.5), 1'500'000'000);
  EXPECT_EQ(DurationOf(-0.25), -250'000'000);
  EXPECT_DOUBLE_EQ(ToSeconds(2'500'000'000), 2.5);
  EXPECT_DOUBLE_EQ(ToSeconds(DurationOf(86400.0)), 86400.0);
}

}  // namespace
}  // namespace enfilade
