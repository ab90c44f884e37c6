// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <random>

#include "core/graph/same_place.h"
#include "fmt/format.h"
#include "fmt/ranges.h"
#include "storage/sites/maintenance.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class LinkPointRowsTest : public StoreTest {
 protected:
  static std::string ArrayOf(const Eigen::Matrix3d& covariance) {
    std::vector<double> numbers;
    for (int i = 0; i < 9; ++i) numbers.push_back(covariance(i / 3, i % 3));
    return fmt::format("'{{{}}}'::float8[]", fmt::join(numbers, ","));
  }
  static Eigen::Matrix3d RandomCovariance(std::mt19937& random) {
    std::uniform_real_distribution<double> element(-0.6, 0.6);
    Eigen::Matrix3d factor;
    for (double& value : factor.reshaped()) value = element(random);
    return factor * factor.transpose();
  }
};

// The rule is graph::FindCommonPlace; the schema's last line of defence must neither be stricter nor let more through.
TEST_F(LinkPointRowsTest, TheSchemaHasTheDistanceOfTheRule) {
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Matrix3d a = RandomCovariance(random) * (i % 10 == 0 ? 0.001 : 1.0);
    const Eigen::Matrix3d b = RandomCovariance(random) * (i % 10 == 0 ? 0.001 : 1.0);
    const double stored = std::stod(
        database_.SqlValue(fmt::format("SELECT enfilade.same_place_distance({}, {})", ArrayOf(a), ArrayOf(b))));
    EXPECT_NEAR(stored, graph::SamePlaceDistance(a, b), 1e-9) << a << "\n" << b;
  }
  EXPECT_EQ(std::stod(database_.SqlValue("SELECT enfilade.same_place_distance(array_fill(0::float8, '{9}'),"
                                         " array_fill(0::float8, '{9}'))")),
            graph::kMinSamePlaceDistance);
}

TEST_F(LinkPointRowsTest, TheTriggerRefusesWhatTheRuleRefuses) {
  for (const char* id : {"lab", "yard"}) ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId(id), id), ""));
  // Around the rule: whether the anchors of a second link point could be stored beside those of the first.
  database_.Sql(
      "CREATE FUNCTION try_insert(maps text[], x float8[], y float8[], covariances float8[]) RETURNS boolean"
      " LANGUAGE plpgsql AS $$ BEGIN"
      " INSERT INTO enfilade.link_points (site_id, link_point_id, kind, changed_version)"
      "   VALUES ('campus', 'second', 1, 1);"
      " INSERT INTO enfilade.link_point_anchors (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)"
      "   SELECT 'campus', 'second', u.map, n, u.x, u.y, 0, covariances[9 * n - 8 : 9 * n]"
      "   FROM unnest(maps, x, y) WITH ORDINALITY u (map, x, y, n);"
      " DELETE FROM enfilade.link_points WHERE link_point_id = 'second'; RETURN true;"
      " EXCEPTION WHEN unique_violation THEN RETURN false; END $$");
  const std::vector<graph::Anchor> first = {MakeAnchor("hall", 10, 0), MakeAnchor("lab", 0, 0),
                                            MakeAnchor("yard", -5, 2)};
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "first", first), ""));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> offset(-0.8, 0.8);
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    std::vector<graph::Anchor> second = first;
    second.erase(second.begin() + i % 3, second.begin() + i % 3 + (i % 4 == 0 ? 0 : 1));
    std::vector<std::string> maps;
    std::vector<double> x, y, covariances;
    for (graph::Anchor& anchor : second) {
      anchor.T_map_place.x += offset(random);
      anchor.T_map_place.y += offset(random);
      anchor.covariance = 0.2 * RandomCovariance(random);
      maps.push_back(anchor.map.value());
      x.push_back(anchor.T_map_place.x);
      y.push_back(anchor.T_map_place.y);
      for (int k = 0; k < 9; ++k) covariances.push_back(anchor.covariance(k / 3, k % 3));
    }
    const std::string stored = database_.SqlValue(
        fmt::format("SELECT try_insert('{{{}}}', '{{{}}}', '{{{}}}', '{{{}}}')", fmt::join(maps, ","),
                    fmt::join(x, ","), fmt::join(y, ","), fmt::join(covariances, ",")));
    const bool redundant = graph::FindCommonPlace(first, second).has_value();
    EXPECT_EQ(stored, redundant ? "f" : "t") << i;
    refused += redundant ? 1 : 0;
  }
  EXPECT_GT(refused, 10);
  EXPECT_LT(refused, 50);
}

TEST_F(LinkPointRowsTest, TheAuditTrailSaysWhoDidWhat) {
  storage::CallContext ann = Soon();
  ann.actor = "ann's \"tool\"";
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint door,
                       link_points_.Create(ann, MakeLinkPoint(site_, "door", {MakeAnchor("hall", 0, 0)}), ""));
  door.point.tag = "new";
  storage::CallContext robot = Soon();
  robot.actor = "robot r1";
  ASSERT_OK(link_points_.Update(robot, door));
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  ASSERT_OK_AND_ASSIGN(const auto entries, audit_.List(Soon(), site_, "linkPoints/door", 0, 100));
  // Newest first: anchor and link point deleted, link point updated, anchor and link point created.
  ASSERT_THAT(entries, SizeIs(5));
  EXPECT_EQ(entries[4].actor, ann.actor);
  EXPECT_EQ(entries[4].action, storage::AuditAction::kCreated);
  EXPECT_THAT(entries[4].before, IsEmpty());
  EXPECT_EQ(entries[3].resource, "linkPoints/door/anchors/hall");
  EXPECT_EQ(entries[2].actor, "robot r1");
  EXPECT_EQ(entries[2].action, storage::AuditAction::kUpdated);
  EXPECT_THAT(entries[2].before, HasSubstr("\"tag\": \"\""));
  EXPECT_THAT(entries[2].after, HasSubstr("\"tag\": \"new\""));
  EXPECT_EQ(entries[0].actor, "");
  EXPECT_THAT(entries[0].after, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto versions, graph_.ListVersions(Soon(), site_, 0, 3));
  ASSERT_THAT(versions, SizeIs(3));
  EXPECT_EQ(versions[0].cause, storage::GraphCause::kLinkPointRemoved);
  EXPECT_EQ(versions[1].actor, "robot r1");
  EXPECT_EQ(versions[2].cause, storage::GraphCause::kLinkPointAdded);
  EXPECT_EQ(versions[2].resource, "linkPoints/door");
  // A change that fails leaves no trace.
  EXPECT_CODE(link_points_.Update(ann, door), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const auto after, audit_.List(Soon(), site_, "linkPoints/door", 0, 100));
  EXPECT_THAT(after, SizeIs(5));
}

TEST_F(LinkPointRowsTest, EvidenceKeepsItsBlobs) {
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "lab"), ""));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "door", {MakeAnchor("hall", 0, 0)}), ""));
  const TestBlob rear("rear image"), cloud("cloud"), unused("unused");
  ASSERT_OK(blobs_.Put(Soon(), site_, {rear.view(), cloud.view(), unused.view()}));
  storage::Evidence evidence{LinkPointId("door"), map_, storage::EvidenceKind::kRearImage, 1, rear.ref(), 42};
  ASSERT_OK(link_points_.PutEvidence(Soon(), site_, evidence));
  evidence.kind = storage::EvidenceKind::kCloud;
  evidence.content = unused.ref();
  ASSERT_OK(link_points_.PutEvidence(Soon(), site_, evidence));
  evidence.content = cloud.ref();
  evidence.encoding = 2;
  ASSERT_OK(link_points_.PutEvidence(Soon(), site_, evidence));
  evidence.map = MapId("lab");
  EXPECT_STATUS(link_points_.PutEvidence(Soon(), site_, evidence), absl::StatusCode::kNotFound, HasSubstr("\"lab\""));
  evidence.map = map_;
  evidence.content = TestBlob("never sent").ref();
  EXPECT_CODE(link_points_.PutEvidence(Soon(), site_, evidence), absl::StatusCode::kInvalidArgument);

  storage::Maintenance maintenance(*pool_);
  ASSERT_OK_AND_ASSIGN(const storage::MaintenancePortion collected,
                       maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 100));
  EXPECT_EQ(collected.deleted, 1) << "the one that was replaced";
  ASSERT_OK_AND_ASSIGN(const auto listed, link_points_.ListEvidence(Soon(), site_, {LinkPointId("door")}));
  ASSERT_THAT(listed, SizeIs(2));
  EXPECT_EQ(listed[0].content, rear.ref());
  EXPECT_EQ(listed[0].time, 42);
  EXPECT_EQ(listed[1].content, cloud.ref());
  EXPECT_EQ(listed[1].encoding, 2);
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  ASSERT_OK_AND_ASSIGN(const storage::MaintenancePortion freed,
                       maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 100));
  EXPECT_EQ(freed.deleted, 2);
}

}  // namespace
}  // namespace enfilade::testing
