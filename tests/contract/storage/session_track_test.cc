// SPDX-License-Identifier: Apache-2.0
#include "core/base/sha256.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

class SessionTrackTest : public StoreTest {};

TEST_F(SessionTrackTest, ARevisionComesWithTheTrackOfItsSession) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 3)));
  ASSERT_OK_AND_ASSIGN(const auto leased, mapping_.Acquire(Soon(), "worker", std::chrono::seconds(60)));
  ASSERT_TRUE(leased);
  slam::SlamDelta delta;
  delta.submaps = {{0, 1, {0.0, 0.0, 0.5}, false, ""}};
  delta.nodes = {{0, 1, kNsPerSecond, {0.0, 1.0 / 3, -0.1}, Eigen::Matrix3d::Identity(), 0},
                 {1, 2, 2 * kNsPerSecond, {1.5, 1.0 / 3, -0.1}, Eigen::Matrix3d::Identity(), 0}};
  const TestBlob tile("tile");
  const std::vector<storage::BlobView> blobs = {tile.view()};
  storage::NewRevision revision;
  revision.session = session;
  revision.content_sha256 = Sha256("content");
  revision.tiles = {{{0, 0}, tile.sha256()}};
  storage::MappingStep step = StepOf(delta, "c", 2);
  ASSERT_OK(mapping_.Commit(Soon(), leased->lease, step));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.session_tracks"), "0");
  step.revision = &revision;
  step.blobs = blobs;
  ASSERT_OK(mapping_.Commit(Soon(), leased->lease, step));
  EXPECT_EQ(database_.SqlValue("SELECT ST_AsText(track) FROM enfilade.session_tracks"),
            "LINESTRING M (0 0.333333333333333 1,1.5 0.333333333333333 2)");
}

}  // namespace
}  // namespace enfilade::testing
