// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

class SiteDeletionTest : public StoreTest {};

TEST_F(SiteDeletionTest, ASiteGoesWithItsGraph) {
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "door", {MakeAnchor("hall", 1, 0)}), ""));
  ASSERT_OK(sites_.Delete(Soon(), site_, 0, true));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.link_points"), "0");
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.site_graphs"), "0");
  EXPECT_NE(database_.SqlValue("SELECT count(*) FROM enfilade.audit_log"), "0");
  ASSERT_OK(sites_.Create(Soon(), MakeSite(site_, "Campus"), ""));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, map_, "Hall"), ""));
}

}  // namespace
}  // namespace enfilade::testing
