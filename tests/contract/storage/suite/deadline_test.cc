// SPDX-License-Identifier: Apache-2.0
#include <functional>

#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::SizeIs;

class DeadlineTest : public StoreContractTest {};

// Every kind of store gives up a call whose time is over, and nothing of it is stored.
TEST_F(DeadlineTest, CallsPastTheirDeadlineFailAndStoreNothing) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 2)));
  ASSERT_OK_AND_ASSIGN(const auto leased, mapping_.Acquire(Soon(), "worker", std::chrono::seconds(60)));
  ASSERT_TRUE(leased);
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_.GetVersion(Soon(), site_));
  const TestBlob blob("blob");
  const std::vector<storage::BlobView> blobs = {blob.view()};
  const std::vector<sensor::Record> more = ScanRecords(3, 4);
  const slam::SlamDelta nothing;
  const storage::CallContext late = storage::CallContext::WithTimeout(std::chrono::milliseconds(-1));
  const std::vector<std::pair<std::string, std::function<absl::Status()>>> calls = {
      {"maps.Create", [&] { return maps_.Create(late, MakeMap(site_, MapId("m"), "M"), "").status(); }},
      {"maps.Get", [&] { return maps_.Get(late, site_, map_).status(); }},
      {"maps.Delete", [&] { return maps_.Delete(late, site_, map_, 0, true); }},
      {"revisions.Get", [&] { return revisions_.Get(late, site_, map_, 0).status(); }},
      {"sessions.Get", [&] { return sessions_.Get(late, site_, session).status(); }},
      {"sessions.Finish", [&] { return sessions_.Finish(late, site_, session, 2).status(); }},
      {"records.Append",
       [&] {
         return records_.Append(late, {site_, session, more, {}}).status();
       }},
      {"records.Read", [&] { return records_.Read(late, site_, session, 1, 100).status(); }},
      {"blobs.Put", [&] { return blobs_.Put(late, site_, blobs); }},
      {"mapping.Acquire", [&] { return mapping_.Acquire(late, "other", std::chrono::seconds(1)).status(); }},
      {"mapping.Commit", [&] { return mapping_.Commit(late, leased->lease, StepOf(nothing, "c", 1)).status(); }},
      {"link_points.Create",
       [&] {
         return link_points_.Create(late, MakeLinkPoint(site_, "door", {MakeAnchor("hall", 0, 0)}), "").status();
       }},
      {"graph.ReadChanges", [&] { return graph_.ReadChanges(late, site_, 0).status(); }},
      {"graph.Apply", [&] { return graph_.Apply(late, site_, version, {}).status(); }},
      {"graph.Listen", [&] { return graph_.Listen(late).status(); }},
      {"leases.Acquire", [&] { return leases_.Acquire(late, site_, "me", std::chrono::seconds(1)).status(); }},
      {"robot_poses.List", [&] { return robot_poses_.List(late, site_).status(); }},
  };
  for (const auto& [name, call] : calls) EXPECT_CODE(call(), absl::StatusCode::kDeadlineExceeded) << name;
  EXPECT_EQ(*graph_.GetVersion(Soon(), site_), version);
  EXPECT_EQ(backend_->CountRecords(), 2);
  EXPECT_EQ(backend_->CountBlobs(), 0);
  ASSERT_OK_AND_ASSIGN(const auto stored, mapping_.Load(Soon(), site_, session));
  EXPECT_FALSE(stored);
  ASSERT_OK_AND_ASSIGN(const auto maps, maps_.List(Soon(), site_, {}));
  EXPECT_THAT(maps, SizeIs(1));
  ASSERT_OK_AND_ASSIGN(const auto lease, leases_.Acquire(Soon(), site_, "me", std::chrono::seconds(1)));
  EXPECT_EQ(lease->token, 1);
}

}  // namespace
}  // namespace enfilade::testing
