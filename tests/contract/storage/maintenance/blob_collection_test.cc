// SPDX-License-Identifier: Apache-2.0
// How unused blobs are found: by a list, whatever is in use.
#include <gmock/gmock.h>

#include <thread>

#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::seconds;
using storage::postgres::Params;
using storage::postgres::Transaction;
using ::testing::IsEmpty;

class BlobCollectionTest : public StoreTest {
 protected:
  std::string Count(const std::string& table) { return database_.SqlValue("SELECT count(*) FROM enfilade." + table); }
  storage::MaintenancePortion Collect(std::int64_t limit = 1000, seconds grace = seconds(0)) {
    const auto collected = maintenance_.CollectBlobs(Soon(), grace, limit);
    EXPECT_OK(collected);
    return collected.value_or(storage::MaintenancePortion());
  }
  storage::MaintenancePortion CollectAll(std::int64_t limit = 1000) {
    storage::MaintenancePortion total;
    while (true) {
      const storage::MaintenancePortion portion = Collect(limit);
      EXPECT_LE(portion.looked_at, limit);
      total.looked_at += portion.looked_at;
      total.deleted += portion.deleted;
      if (portion.looked_at < limit) return total;
    }
  }
  // Blobs that a revision of the map refers to.
  void AddBlobsInUse(int count) {
    database_.Sql(fmt::format(
        "INSERT INTO enfilade.blobs (site_id, sha256, data, put_time)"
        " SELECT '{0}', sha256(n::text::bytea), 'x', now() - interval '1 day' FROM generate_series(1, {2}) n;"
        "INSERT INTO enfilade.map_revisions (site_id, map_id, revision, source, resolution, origin_x, origin_y,"
        " origin_yaw, width, height, raster_header, content_sha256, tile_count, tile_bytes)"
        " VALUES ('{0}', '{1}', 1, 2, 0.05, 0, 0, 0, 1, 1, 'h', sha256('c'), {2}, {2});"
        "INSERT INTO enfilade.map_revision_tiles (site_id, map_id, revision, tile_row, tile_column, sha256)"
        " SELECT '{0}', '{1}', 1, n, 0, sha256(n::text::bytea) FROM generate_series(1, {2}) n;"
        "ANALYZE enfilade.blobs, enfilade.map_revision_tiles",
        site_.value(), map_.value(), count));
  }
  // Rows of all tables that another server reads while it looks for unused blobs.
  std::int64_t RowsReadByALook() {
    const std::int64_t before = RowsRead();
    {
      const auto pool = PoolNamed("looks-for-blobs");
      EXPECT_OK(storage::Maintenance(*pool).CollectBlobs(Soon(), seconds(0), 1000));
    }
    // A connection hands in its statistics when it ends.
    while (database_.SqlValue("SELECT count(*) FROM pg_stat_activity WHERE application_name = 'looks-for-blobs'") !=
           "0") {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return RowsRead() - before;
  }
  std::int64_t RowsRead() {
    return std::stoll(
        database_.SqlValue("SELECT sum(coalesce(seq_tup_read, 0) + coalesce(idx_tup_fetch, 0))::bigint"
                           " FROM pg_stat_user_tables WHERE schemaname = 'enfilade'"));
  }
  std::unique_ptr<storage::postgres::Pool> PoolNamed(const std::string& name) {
    storage::postgres::PoolOptions options;
    options.url = database_.url();
    options.application_name = name;
    auto pool = storage::postgres::Pool::Create(options);
    EXPECT_OK(pool);
    return *std::move(pool);
  }
  void Put(const TestBlob& blob) { ASSERT_OK(blobs_.Put(Soon(), site_, {blob.view()})); }
  bool IsStored(const TestBlob& blob) { return blobs_.Get(Soon(), site_, blob.sha256()).ok(); }

  storage::Maintenance maintenance_{*pool_};
};

TEST_F(BlobCollectionTest, ALookReadsTheSameHoweverManyBlobsAreInUse) {
  AddBlobsInUse(20'000);
  EXPECT_EQ(CollectAll().deleted, 0);
  EXPECT_EQ(Count("loose_blobs"), "0");
  const TestBlob unused("unused");
  Put(unused);
  const std::int64_t rows = RowsReadByALook();
  EXPECT_GT(rows, 0);
  EXPECT_LE(rows, 50);
  EXPECT_FALSE(IsStored(unused));
  EXPECT_EQ(Count("blobs"), "20000");
  database_.Sql("INSERT INTO enfilade.loose_blobs SELECT site_id, sha256, '-infinity' FROM enfilade.blobs LIMIT 500");
  EXPECT_LE(RowsReadByALook(), 10 * 500) << "each listed blob is looked for by itself";
}

TEST_F(BlobCollectionTest, WhatLosesItsLastReferenceIsCollected) {
  AddBlobsInUse(30);
  EXPECT_EQ(CollectAll().deleted, 0);
  database_.Sql("UPDATE enfilade.map_revision_tiles SET sha256 = sha256('1') WHERE tile_row <= 10");
  EXPECT_EQ(CollectAll().deleted, 9);
  database_.Sql("DELETE FROM enfilade.map_revision_tiles WHERE tile_row <= 9");
  EXPECT_EQ(CollectAll().deleted, 0) << "the tenth refers to it, too";
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_EQ(CollectAll(7).deleted, 21) << "in portions";
  EXPECT_EQ(Count("blobs"), "0");
  EXPECT_EQ(Count("loose_blobs"), "0");
}

TEST_F(BlobCollectionTest, ABlobIsKeptForItsGracePeriod) {
  const TestBlob blob("just put");
  Put(blob);
  EXPECT_EQ(Collect(1000, seconds(3600)).looked_at, 0);
  // It is known to be loose since long ago, and was put again just now.
  database_.Sql("UPDATE enfilade.loose_blobs SET since = '-infinity'");
  EXPECT_EQ(Collect(1000, seconds(3600)).deleted, 0);
  EXPECT_EQ(Collect(1000, seconds(3600)).looked_at, 0) << "not again before the period is over";
  EXPECT_EQ(Count("loose_blobs"), "1");
  EXPECT_EQ(Collect().deleted, 1);
}

// Another connection refers to a blob, and commits only after it was looked at.
TEST_F(BlobCollectionTest, ABlobThatIsReferredToMeanwhileSurvives) {
  const TestBlob image("image"), other("other");
  Put(image);
  Put(other);
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "door", {MakeAnchor("hall", 0, 0)}), ""));
  ASSERT_OK_AND_ASSIGN(Transaction transaction, Transaction::Begin(*pool_, Soon()));
  ASSERT_OK(transaction.Execute({"referring",
                                 "INSERT INTO enfilade.link_point_evidence (site_id, link_point_id, map_id, kind,"
                                 " ordinal, encoding, sha256, time_ns) SELECT $1, 'door', 'hall', 1, 1, 1, $2, 1"},
                                Params(site_, storage::postgres::Bytes{image.sha256()})));
  EXPECT_EQ(CollectAll().deleted, 1) << "the other one";
  ASSERT_OK(transaction.Commit());
  EXPECT_EQ(CollectAll().deleted, 0);
  EXPECT_TRUE(IsStored(image));
  EXPECT_FALSE(IsStored(other));
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  EXPECT_EQ(CollectAll().deleted, 1) << "it was not forgotten";
}

// Another connection removes the last reference, and commits only after the blob was found in use.
TEST_F(BlobCollectionTest, ABlobWhoseReferenceGoesMeanwhileIsNotForgotten) {
  AddBlobsInUse(1);
  ASSERT_OK_AND_ASSIGN(Transaction transaction, Transaction::Begin(*pool_, Soon()));
  ASSERT_OK(
      transaction.Execute({"removing", "DELETE FROM enfilade.map_revision_tiles WHERE site_id = $1"}, Params(site_)));
  EXPECT_EQ(CollectAll().deleted, 0);
  EXPECT_EQ(Count("loose_blobs"), "0");
  ASSERT_OK(transaction.Commit());
  EXPECT_EQ(CollectAll().deleted, 1);
}

TEST_F(BlobCollectionTest, TwoServersDoTheWorkOnce) {
  AddBlobsInUse(2000);
  database_.Sql(
      "DELETE FROM enfilade.map_revision_tiles WHERE tile_row > 500; TRUNCATE enfilade.loose_blobs;"
      "INSERT INTO enfilade.loose_blobs SELECT site_id, sha256, '-infinity' FROM enfilade.blobs");
  std::array<storage::MaintenancePortion, 2> done;
  std::vector<std::thread> servers;
  for (storage::MaintenancePortion& mine : done) {
    servers.emplace_back([this, &mine] {
      const auto pool = PoolNamed("server");
      const storage::Maintenance maintenance(*pool);
      while (Count("loose_blobs") != "0") {
        const auto portion = maintenance.CollectBlobs(Soon(), seconds(0), 50);
        ASSERT_OK(portion);
        mine.looked_at += portion->looked_at;
        mine.deleted += portion->deleted;
      }
    });
  }
  for (std::thread& server : servers) server.join();
  EXPECT_EQ(done[0].looked_at + done[1].looked_at, 2000);
  EXPECT_EQ(done[0].deleted + done[1].deleted, 1500);
  EXPECT_EQ(Count("blobs"), "500");
}

// As after an upgrade: there are blobs, and no list.
TEST_F(BlobCollectionTest, BlobsFromBeforeThereWasAListAreListedInPortions) {
  AddBlobsInUse(1000);
  database_.Sql(
      "DELETE FROM enfilade.map_revision_tiles WHERE tile_row > 700; TRUNCATE enfilade.loose_blobs;"
      "INSERT INTO enfilade.blob_listings VALUES ('" +
      site_.value() + "', '')");
  EXPECT_EQ(Collect(100).looked_at, 100) << "listed";
  EXPECT_EQ(Count("loose_blobs"), "100");
  EXPECT_EQ(CollectAll(100).deleted, 300);
  EXPECT_EQ(Count("blobs"), "700");
  EXPECT_EQ(Count("blob_listings"), "0");
  EXPECT_EQ(Count("loose_blobs"), "0");
}

// A new table with references must list what it no longer refers to.
TEST_F(BlobCollectionTest, EveryReferenceToABlobIsFollowed) {
  EXPECT_THAT(
      database_.Sql("SELECT c.conrelid::regclass FROM pg_constraint c"
                    " WHERE c.confrelid = 'enfilade.blobs'::regclass AND c.contype = 'f' AND c.confdeltype = 'a'"
                    " AND (SELECT count(*) FROM pg_trigger t WHERE t.tgrelid = c.conrelid"
                    "   AND t.tgfoid = 'enfilade.list_blob'::regproc) <> 2"),
      IsEmpty());
}

}  // namespace
}  // namespace enfilade::testing
