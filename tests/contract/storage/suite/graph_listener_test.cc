// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <thread>

#include "fmt/format.h"
#include "storage/graph/graph_store.h"
#include "tests/contract/storage/suite/contract_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

class GraphListenerTest : public StoreContractTest {
 protected:
  GraphListenerTest() { EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), "")); }

  void Create(const std::string& id, const std::vector<graph::Anchor>& anchors) {
    ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, id, anchors), ""));
  }
  std::int64_t Version() { return graph_.GetVersion(Soon(), site_).value_or(-1); }
};

TEST_F(GraphListenerTest, ListenersHearOfEveryVersion) {
  ASSERT_OK_AND_ASSIGN(const auto listener, graph_.Listen(Soon()));
  ASSERT_OK_AND_ASSIGN(const auto nothing,
                       listener->Await(storage::CallContext::WithTimeout(std::chrono::milliseconds(1))));
  EXPECT_THAT(nothing, IsEmpty());
  const std::int64_t version = Version();
  Create("door", {MakeAnchor("hall", 1, 0)});
  ASSERT_OK_AND_ASSIGN(const auto changes, listener->Await(Soon()));
  ASSERT_THAT(changes, SizeIs(1));
  EXPECT_EQ(changes[0].site, site_);
  EXPECT_EQ(changes[0].version, version + 1);
}

TEST_F(GraphListenerTest, EveryListenerReceivesTheVersionsOfAllSitesSinceItListens) {
  backend_->AddSite(SiteId("other"));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(SiteId("other"), map_, "Hall"), ""));
  ASSERT_OK_AND_ASSIGN(const auto early, graph_.Listen(Soon()));
  Create("a", {MakeAnchor("hall", 1, 0)});
  ASSERT_OK_AND_ASSIGN(const auto late, graph_.Listen(Soon()));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(SiteId("other"), "b", {MakeAnchor("hall", 1, 0)}), ""));
  const auto versions = [&](storage::GraphListener& listener, std::size_t count) {
    std::vector<std::string> received;
    while (received.size() < count) {
      const auto changes = listener.Await(Soon());
      EXPECT_OK(changes);
      if (!changes.ok() || changes->empty()) break;
      for (const auto& change : *changes) received.push_back(fmt::format("{} {}", change.site.value(), change.version));
    }
    return received;
  };
  EXPECT_THAT(versions(*early, 2), ElementsAre("campus 3", "other 2"));
  EXPECT_THAT(versions(*late, 1), ElementsAre("other 2"));
  // A change that fails is none.
  EXPECT_CODE(link_points_.Delete(Soon(), site_, LinkPointId("z"), 0), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const auto nothing,
                       late->Await(storage::CallContext::WithTimeout(std::chrono::milliseconds(50))));
  EXPECT_THAT(nothing, IsEmpty());
}

TEST_F(GraphListenerTest, ListsTheVersionsOfTheSitesThatAreAskedFor) {
  for (const char* site : {"other", "third", "empty"}) backend_->AddSite(SiteId(site));
  for (const char* site : {"other", "third"}) ASSERT_OK(maps_.Create(Soon(), MakeMap(SiteId(site), map_, "Hall"), ""));
  Create("a", {MakeAnchor("hall", 1, 0)});
  ASSERT_OK_AND_ASSIGN(const auto versions,
                       graph_.ListVersionsOf(Soon(), {SiteId("other"), site_, SiteId("empty"), SiteId("nowhere")}));
  std::vector<std::string> listed;
  for (const auto& site : versions) listed.push_back(fmt::format("{} {}", site.site.value(), site.version));
  EXPECT_THAT(listed, UnorderedElementsAre("campus 3", "other 1"));
  ASSERT_OK_AND_ASSIGN(const auto none, graph_.ListVersionsOf(Soon(), {}));
  EXPECT_THAT(none, IsEmpty());
}

TEST_F(GraphListenerTest, ListenersHearOfMapsToo) {
  ASSERT_OK_AND_ASSIGN(const auto listener, graph_.Listen(Soon()));
  const std::int64_t version = Version();
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("attic"), "Attic"), ""));
  ASSERT_OK_AND_ASSIGN(const auto changes, listener->Await(Soon()));
  ASSERT_THAT(changes, SizeIs(1));
  EXPECT_EQ(changes[0].version, version + 1);
}

TEST_F(GraphListenerTest, AListenerWakesUpWhenSomethingChanges) {
  ASSERT_OK_AND_ASSIGN(const auto listener, graph_.Listen(Soon()));
  std::thread editor([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    Create("door", {MakeAnchor("hall", 1, 0)});
  });
  const auto changes = listener->Await(Soon());
  editor.join();
  ASSERT_OK(changes);
  EXPECT_THAT(*changes, SizeIs(1));
}

}  // namespace
}  // namespace enfilade::testing
