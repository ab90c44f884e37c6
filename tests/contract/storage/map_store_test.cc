// SPDX-License-Identifier: Apache-2.0
#include "storage/map_store.h"

#include <limits>

#include "core/base/environment.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<Eigen::Vector2d> Square(double x, double y, double side) {
  return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}

class MapStoreTest : public StoreTest {
 protected:
  storage::Map Get(const std::string& id) {
    const auto map = maps_.Get(Soon(), site_, MapId(id));
    EXPECT_OK(map);
    return *map;
  }
};

TEST_F(MapStoreTest, GivesBackWhatWasStored) {
  storage::Map map = MakeMap(site_, MapId("lab"), "Lab 1/2 \"west\" \xf0\x9f\xa4\x96");
  map.level = -2;
  map.environment = Environment::kOutdoor;
  map.slam_profile = "outdoor-fast";
  map.outline = {{500'000.1, 5'800'000.2}, {500'010.3, 5'800'000.2}, {500'005.0, 5'800'009.4}};
  ASSERT_OK(maps_.Create(Soon(), map, ""));
  const storage::Map stored = Get("lab");
  EXPECT_EQ(stored.display_name, map.display_name);
  EXPECT_EQ(stored.level, -2);
  EXPECT_EQ(stored.environment, Environment::kOutdoor);
  EXPECT_EQ(stored.slam_profile, "outdoor-fast");
  EXPECT_EQ(stored.outline, map.outline);
  EXPECT_EQ(stored.state, storage::MapState::kEmpty);
  EXPECT_EQ(stored.current_revision, 0);
  EXPECT_THAT(Get("hall").outline, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const storage::Map named, maps_.GetByDisplayName(Soon(), site_, map.display_name));
  EXPECT_EQ(named.id, map.id);
  EXPECT_CODE(maps_.GetByDisplayName(Soon(), site_, "lab"), absl::StatusCode::kNotFound);
}

TEST_F(MapStoreTest, SaysWhatIsTaken) {
  EXPECT_STATUS(maps_.Create(Soon(), MakeMap(site_, map_, "Other"), ""), absl::StatusCode::kAlreadyExists,
                HasSubstr("sites/campus/maps/hall exists"));
  EXPECT_STATUS(maps_.Create(Soon(), MakeMap(site_, MapId("hall2"), "Hall"), ""), absl::StatusCode::kAlreadyExists,
                HasSubstr("\"Hall\""));
  EXPECT_STATUS(maps_.Create(Soon(), MakeMap(SiteId("nowhere"), map_, "Hall"), ""), absl::StatusCode::kNotFound,
                HasSubstr("sites/nowhere"));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("a"), "A"), "request"));
  ASSERT_OK_AND_ASSIGN(const storage::Map repeated, maps_.Create(Soon(), MakeMap(site_, MapId("b"), "A"), "request"));
  EXPECT_EQ(repeated.id, MapId("a"));
}

TEST_F(MapStoreTest, RefusesOutlinesThatAreNoSimplePolygons) {
  storage::Map map = MakeMap(site_, MapId("m"), "M");
  map.outline = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};
  EXPECT_STATUS(maps_.Create(Soon(), map, ""), absl::StatusCode::kInvalidArgument, HasSubstr("outline"));
  map.outline = {{0, 0}, {1, 1}};
  EXPECT_STATUS(maps_.Create(Soon(), map, ""), absl::StatusCode::kInvalidArgument, HasSubstr("2 corners"));
  map.outline = {{0, 0}, {1, std::numeric_limits<double>::quiet_NaN()}, {1, 0}};
  EXPECT_STATUS(maps_.Create(Soon(), map, ""), absl::StatusCode::kInvalidArgument, HasSubstr("finite"));
  map.outline = {};
  map.environment = static_cast<Environment>(7);
  EXPECT_CODE(maps_.Create(Soon(), map, ""), absl::StatusCode::kInvalidArgument);
}

TEST_F(MapStoreTest, UpdatesOnlyUnderTheStoredEtag) {
  storage::Map map = Get("hall");
  map.display_name = "Great hall";
  map.level = 3;
  map.outline = Square(0, 0, 10);
  ASSERT_OK_AND_ASSIGN(const storage::Map updated, maps_.Update(Soon(), map));
  EXPECT_EQ(updated.outline, map.outline);
  EXPECT_EQ(Get("hall").level, 3);
  EXPECT_CODE(maps_.Update(Soon(), map), absl::StatusCode::kAborted);
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), ""));
  map.etag = updated.etag;
  map.display_name = "Lab";
  EXPECT_STATUS(maps_.Update(Soon(), map), absl::StatusCode::kAlreadyExists, HasSubstr("\"Lab\""));
  map.id = MapId("nowhere");
  EXPECT_CODE(maps_.Update(Soon(), map), absl::StatusCode::kNotFound);
}

TEST_F(MapStoreTest, IsKeptWhileSessionsMapIntoIt) {
  const SessionId first = NewSession("s1");
  NewSession("s2");
  EXPECT_STATUS(maps_.Delete(Soon(), site_, map_, 0, false), absl::StatusCode::kFailedPrecondition,
                HasSubstr("s1, s2"));
  ASSERT_OK(Append(first, ScanRecords(1, 3)));
  ASSERT_OK_AND_ASSIGN(const auto leased, mapping_.Acquire(Soon(), "worker", std::chrono::seconds(60)));
  ASSERT_TRUE(leased);
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_CODE(maps_.Get(Soon(), site_, map_), absl::StatusCode::kNotFound);
  EXPECT_CODE(sessions_.Get(Soon(), site_, first), absl::StatusCode::kNotFound);
  EXPECT_CODE(Append(first, {ScanRecord(4)}), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(mapping_.Renew(Soon(), leased->lease, std::chrono::seconds(60)), absl::StatusCode::kAborted);
}

TEST_F(MapStoreTest, AMapMadeAgainUnderAnOldIdStartsAnew) {
  for (const char* id : {"a", "b", "c"}) ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId(id), id), ""));
  const TestBlob blob("tile");
  storage::NewRevision revision;
  revision.source = storage::RevisionSource::kImport;
  revision.content_sha256 = blob.sha256();
  revision.tiles = {{{0, 0}, blob.sha256()}};
  ASSERT_OK(revisions_.Add(Soon(), site_, MapId("b"), revision, {blob.view()}));
  const storage::Map old = Get("b");
  EXPECT_CODE(maps_.Delete(Soon(), site_, MapId("b"), old.etag + 1, false), absl::StatusCode::kAborted);
  ASSERT_OK(maps_.Delete(Soon(), site_, MapId("b"), old.etag, false));
  EXPECT_CODE(maps_.Delete(Soon(), site_, MapId("b"), 0, false), absl::StatusCode::kNotFound);
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("b"), "b"), ""));
  EXPECT_EQ(Get("b").current_revision, 0);
  EXPECT_EQ(Get("b").state, storage::MapState::kEmpty);
  EXPECT_CODE(revisions_.Get(Soon(), site_, MapId("b"), 1), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const auto page, maps_.List(Soon(), site_, {2, "a"}));
  ASSERT_EQ(page.size(), 2U);
  EXPECT_EQ(page[0].id, MapId("b"));
  EXPECT_EQ(page[1].id, MapId("c"));
}

}  // namespace
}  // namespace enfilade::testing
