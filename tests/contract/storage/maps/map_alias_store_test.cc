// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/map_alias_store.h"

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using storage::MapAlias;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class MapAliasStoreTest : public StoreTest {
 protected:
  MapAliasStoreTest() {
    for (const char content : {'a', 'b', 'c', 'd'}) AddRevision(content);
  }
  void AddRevision(char content) {
    const TestBlob tile(std::string("tile ") + content);
    storage::NewRevision revision;
    revision.source = storage::RevisionSource::kImport;
    revision.geometry = {0.05, {}, 256, 256};
    revision.raster_header = "h";
    revision.content_sha256 = tile.sha256();
    revision.tiles = {{{0, 0}, tile.sha256()}};
    ASSERT_OK(revisions_.Add(Soon(), site_, map_, revision, {tile.view()}));
  }
  static storage::CallContext As(const std::string& actor) {
    storage::CallContext context = Soon();
    context.actor = actor;
    return context;
  }
  absl::StatusOr<MapAlias> Set(const std::string& id, std::int64_t revision, std::int64_t etag = 0,
                               const std::string& actor = "ada") {
    MapAlias alias{.site = site_, .map = map_, .id = MapAliasId(id), .revision = revision};
    alias.etag = etag;
    return aliases_.Set(As(actor), alias);
  }
  std::vector<MapAliasId> AliasesOf(std::int64_t revision) {
    const auto found = revisions_.Get(Soon(), site_, map_, revision);
    EXPECT_OK(found);
    return found.ok() ? found->aliases : std::vector<MapAliasId>{};
  }
  std::vector<std::int64_t> Revisions() {
    std::vector<std::int64_t> numbers;
    const auto revisions = revisions_.List(Soon(), site_, map_, 0, 1000);
    EXPECT_OK(revisions);
    for (const storage::MapRevision& revision : *revisions) numbers.push_back(revision.number);
    return numbers;
  }

  const MapAliasId stable_{"stable"};
  storage::MapAliasStore aliases_{*pool_};
};

TEST_F(MapAliasStoreTest, LeadsToARevisionUntilItIsMoved) {
  ASSERT_OK_AND_ASSIGN(const MapAlias made, Set("stable", 1));
  EXPECT_EQ(made.revision, 1);
  EXPECT_EQ(made.previous_revision, 0);
  EXPECT_EQ(made.actor, "ada");
  EXPECT_GT(made.update_time, 0);
  EXPECT_THAT(AliasesOf(1), ElementsAre(stable_));
  ASSERT_OK_AND_ASSIGN(const MapAlias moved, Set("stable", 3, made.etag, "bob"));
  EXPECT_EQ(moved.revision, 3);
  EXPECT_EQ(moved.previous_revision, 1);
  EXPECT_EQ(moved.actor, "bob");
  EXPECT_NE(moved.etag, made.etag);
  EXPECT_THAT(AliasesOf(1), IsEmpty());
  EXPECT_THAT(AliasesOf(3), ElementsAre(stable_));
  ASSERT_OK_AND_ASSIGN(const MapAlias found, aliases_.Get(Soon(), site_, map_, stable_));
  EXPECT_EQ(found.revision, 3);
  EXPECT_EQ(found.etag, moved.etag);
}

TEST_F(MapAliasStoreTest, SettingItToWhereItLeadsChangesNothing) {
  ASSERT_OK(Set("stable", 1));
  ASSERT_OK_AND_ASSIGN(const MapAlias moved, Set("stable", 2));
  ASSERT_OK_AND_ASSIGN(const MapAlias again, Set("stable", 2, moved.etag, "bob"));
  EXPECT_EQ(again.previous_revision, 1) << "it can still be led back";
  EXPECT_EQ(again.etag, moved.etag);
  EXPECT_EQ(again.actor, "ada");
}

TEST_F(MapAliasStoreTest, OfTwoWhoMoveItTheSecondHasToReadAgain) {
  ASSERT_OK_AND_ASSIGN(const MapAlias made, Set("stable", 1));
  ASSERT_OK(Set("stable", 2, made.etag));
  EXPECT_STATUS(Set("stable", 3, made.etag), absl::StatusCode::kAborted, HasSubstr("maps/hall/aliases/stable"));
  EXPECT_CODE(aliases_.RollBack(Soon(), site_, map_, stable_, made.etag), absl::StatusCode::kAborted);
  EXPECT_CODE(aliases_.Delete(Soon(), site_, map_, stable_, made.etag), absl::StatusCode::kAborted);
  ASSERT_OK_AND_ASSIGN(const MapAlias found, aliases_.Get(Soon(), site_, map_, stable_));
  EXPECT_EQ(found.revision, 2);
}

TEST_F(MapAliasStoreTest, OfManyWhoMoveItAtOnceExactlyOneSucceeds) {
  ASSERT_OK_AND_ASSIGN(const MapAlias made, Set("stable", 1));
  std::atomic<int> moved = 0, aborted = 0;
  std::vector<std::thread> people;
  for (int person = 0; person < 8; ++person) {
    people.emplace_back([&, person] {
      const auto set = Set("stable", 2 + person % 3, made.etag);
      moved += set.ok() ? 1 : 0;
      aborted += absl::IsAborted(set.status()) ? 1 : 0;
    });
  }
  for (std::thread& person : people) person.join();
  EXPECT_EQ(moved, 1);
  EXPECT_EQ(aborted, 7);
}

TEST_F(MapAliasStoreTest, IsLedBackAndForth) {
  ASSERT_OK(Set("stable", 1));
  EXPECT_STATUS(aliases_.RollBack(Soon(), site_, map_, stable_, 0), absl::StatusCode::kFailedPrecondition,
                HasSubstr("revision 1 only"));
  ASSERT_OK(Set("stable", 4));
  ASSERT_OK_AND_ASSIGN(const MapAlias back, aliases_.RollBack(As("eve"), site_, map_, stable_, 0));
  EXPECT_EQ(back.revision, 1);
  EXPECT_EQ(back.previous_revision, 4);
  EXPECT_EQ(back.actor, "eve");
  ASSERT_OK_AND_ASSIGN(const MapAlias forth, aliases_.RollBack(Soon(), site_, map_, stable_, back.etag));
  EXPECT_EQ(forth.revision, 4);
}

TEST_F(MapAliasStoreTest, NamesWhatIsMissing) {
  constexpr auto kNotFound = absl::StatusCode::kNotFound;
  EXPECT_STATUS(Set("stable", 9), kNotFound, HasSubstr("maps/hall/revisions/9"));
  EXPECT_STATUS(Set("stable", 1, 77), kNotFound, HasSubstr("aliases/stable")) << "somebody has deleted it";
  EXPECT_STATUS(aliases_.Get(Soon(), site_, map_, stable_), kNotFound, HasSubstr("aliases/stable"));
  EXPECT_CODE(aliases_.RollBack(Soon(), site_, map_, stable_, 0), kNotFound);
  EXPECT_CODE(aliases_.Delete(Soon(), site_, map_, stable_, 0), kNotFound);
  EXPECT_STATUS(aliases_.List(Soon(), site_, MapId("none")), kNotFound, HasSubstr("maps/none"));
  MapAlias elsewhere{.site = site_, .map = MapId("none"), .id = stable_, .revision = 1};
  EXPECT_STATUS(aliases_.Set(Soon(), elsewhere), kNotFound, HasSubstr("maps/none"));
}

TEST_F(MapAliasStoreTest, ListsThemByName) {
  ASSERT_OK_AND_ASSIGN(const auto none, aliases_.List(Soon(), site_, map_));
  EXPECT_THAT(none, IsEmpty());
  ASSERT_OK(Set("stable", 1));
  ASSERT_OK(Set("canary", 1));
  ASSERT_OK_AND_ASSIGN(const auto both, aliases_.List(Soon(), site_, map_));
  ASSERT_THAT(both, SizeIs(2));
  EXPECT_EQ(both[0].id, MapAliasId("canary"));
  EXPECT_EQ(both[1].id, stable_);
  EXPECT_THAT(AliasesOf(1), ElementsAre(MapAliasId("canary"), stable_));
  ASSERT_OK(aliases_.Delete(Soon(), site_, map_, MapAliasId("canary"), both[0].etag));
  EXPECT_THAT(AliasesOf(1), ElementsAre(stable_));
}

TEST_F(MapAliasStoreTest, AMapHasAtMostAHundred) {
  for (int i = 0; i < storage::MapAliasStore::kMaxAliases; ++i) ASSERT_OK(Set("a" + std::to_string(i), 1));
  EXPECT_STATUS(Set("one-more", 1), absl::StatusCode::kResourceExhausted, HasSubstr("delete one"));
  ASSERT_OK(Set("a0", 2)) << "those that are there can be moved";
  ASSERT_OK(aliases_.Delete(Soon(), site_, map_, MapAliasId("a7"), 0));
  ASSERT_OK(Set("one-more", 1));
}

TEST_F(MapAliasStoreTest, RetentionKeepsWhereItLeadsAndWhereItCanBeLedBack) {
  AddRevision('e');
  ASSERT_OK(Set("stable", 1));
  ASSERT_OK(Set("stable", 2));
  ASSERT_OK_AND_ASSIGN(storage::Site site, sites_.Get(Soon(), site_));
  site.revision_retention = storage::RevisionRetention{.newest = 1};
  ASSERT_OK(sites_.Update(Soon(), site));
  const storage::Maintenance maintenance(*pool_);
  ASSERT_OK(maintenance.DeleteRevisions(Soon(), 1000));
  EXPECT_THAT(Revisions(), ElementsAre(5, 2, 1));
  ASSERT_OK(aliases_.RollBack(Soon(), site_, map_, stable_, 0));
  ASSERT_OK(Set("stable", 5));
  ASSERT_OK(maintenance.DeleteRevisions(Soon(), 1000));
  EXPECT_THAT(Revisions(), ElementsAre(5, 1)) << "it has left 2 for good";
  ASSERT_OK(aliases_.Delete(Soon(), site_, map_, stable_, 0));
  ASSERT_OK(maintenance.DeleteRevisions(Soon(), 1000));
  EXPECT_THAT(Revisions(), ElementsAre(5));
}

TEST_F(MapAliasStoreTest, GoesWithItsMap) {
  ASSERT_OK(Set("stable", 1));
  ASSERT_OK(Set("stable", 2));
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_CODE(aliases_.Get(Soon(), site_, map_, stable_), absl::StatusCode::kNotFound);
}

TEST_F(MapAliasStoreTest, GoesWithItsSite) {
  ASSERT_OK(Set("stable", 1));
  DeleteSite(site_);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.map_aliases"), "0");
}

TEST_F(MapAliasStoreTest, WhoMovedItIsAudited) {
  ASSERT_OK(Set("stable", 1));
  ASSERT_OK(Set("stable", 2, 0, "bob"));
  ASSERT_OK(aliases_.Delete(As("eve"), site_, map_, stable_, 0));
  ASSERT_OK_AND_ASSIGN(const auto entries, audit_.List(Soon(), site_, "maps/hall/aliases", 0, 100));
  std::vector<std::string> actors;
  for (const storage::AuditEntry& entry : entries) actors.push_back(entry.resource + " " + entry.actor);
  EXPECT_THAT(actors, ElementsAre("maps/hall/aliases/stable eve", "maps/hall/aliases/stable bob",
                                  "maps/hall/aliases/stable ada"));
}

}  // namespace
}  // namespace enfilade::testing
