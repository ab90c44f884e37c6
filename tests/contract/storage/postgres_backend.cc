// SPDX-License-Identifier: Apache-2.0
#include "fmt/format.h"
#include "storage/postgres/graph/graph_store.h"
#include "storage/postgres/graph/link_point_store.h"
#include "storage/postgres/graph/robot_pose_store.h"
#include "storage/postgres/graph/site_lease_store.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/map_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/rearrange/rearrangement_store.h"
#include "storage/postgres/sessions/mapping_store.h"
#include "storage/postgres/sessions/record_store.h"
#include "storage/postgres/sessions/session_store.h"
#include "storage/sites/robot_store.h"
#include "storage/sites/site_store.h"
#include "tests/contract/storage/store_values.h"
#include "tests/contract/storage/suite/backend.h"
#include "tests/support/database.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {
namespace {

std::unique_ptr<storage::postgres::Pool> MakePool(const std::string& url) {
  auto pool = storage::postgres::Pool::Create({.url = url});
  EXPECT_OK(pool);
  return *std::move(pool);
}

class PostgresBackend final : public Backend {
 public:
  const storage::MapStore& maps() const override { return maps_; }
  const storage::RevisionStore& revisions() const override { return revisions_; }
  const storage::SessionStore& sessions() const override { return sessions_; }
  const storage::RecordStore& records() const override { return records_; }
  const storage::BlobStore& blobs() const override { return blobs_; }
  const storage::MappingStore& mappings() const override { return mappings_; }
  const storage::LinkPointStore& link_points() const override { return link_points_; }
  const storage::GraphStore& graphs() const override { return graphs_; }
  const storage::SiteLeaseStore& site_leases() const override { return site_leases_; }
  const storage::RobotPoseStore& robot_poses() const override { return robot_poses_; }
  const storage::RearrangementStore& rearrangements() const override { return rearrangements_; }

  void AddSite(const SiteId& site) override {
    EXPECT_OK(storage::SiteStore(*pool_).Create(Soon(), MakeSite(site, site.value()), ""));
  }
  void AddRobot(const SiteId& site, const RobotId& robot) override {
    EXPECT_OK(storage::RobotStore(*pool_).Create(Soon(), MakeRobot(site, robot, robot.value()), ""));
  }
  void EnterMap(const SiteId& site, const SessionId& session, const MapId& map,
                const PoseWithCovariance& T_map_robot) override {
    const Pose2& pose = T_map_robot.pose;
    database_.Sql(
        fmt::format("UPDATE enfilade.sessions SET map_id = '{}', initial_x = {}, initial_y = {},"
                    " initial_yaw = {}, initial_covariance = '{{1,0,0,0,1,0,0,0,1}}' WHERE {}",
                    map.value(), pose.x, pose.y, pose.yaw, Is(site, session)));
    database_.Sql(
        fmt::format("INSERT INTO enfilade.mapping_work (site_id, session_id) SELECT site_id, session_id"
                    " FROM enfilade.sessions WHERE {} AND acknowledged_sequence > 0",
                    Is(site, session)));
  }
  void ExpireRecords(const SiteId& site, const SessionId& session) override {
    database_.Sql("DELETE FROM enfilade.session_records WHERE " + Is(site, session));
    database_.Sql("UPDATE enfilade.sessions SET records_deleted = true WHERE " + Is(site, session));
  }
  void CorruptRecord(const SiteId& site, const SessionId& session, std::int64_t sequence) override {
    database_.Sql(fmt::format("UPDATE enfilade.session_records SET payload = '\\x00' WHERE {} AND sequence = {}",
                              Is(site, session), sequence));
  }

  std::int64_t CountBlobs() const override { return Count("blobs"); }
  std::int64_t CountRecords() const override { return Count("session_records"); }
  std::int64_t CountRevisions() const override { return Count("map_revisions"); }

 private:
  static storage::CallContext Soon() { return storage::CallContext::WithTimeout(std::chrono::seconds(60)); }
  static std::string Is(const SiteId& site, const SessionId& session) {
    return fmt::format("site_id = '{}' AND session_id = '{}'", site.value(), session.value());
  }
  std::int64_t Count(const std::string& table) const {
    return std::stoll(database_.SqlValue("SELECT count(*) FROM enfilade." + table));
  }

  const TestDatabase database_;
  const std::unique_ptr<storage::postgres::Pool> pool_ = MakePool(database_.url());
  const storage::postgres::MapStore maps_{*pool_};
  const storage::postgres::RevisionStore revisions_{*pool_};
  const storage::postgres::SessionStore sessions_{*pool_};
  const storage::postgres::RecordStore records_{*pool_};
  const storage::postgres::BlobStore blobs_{*pool_};
  const storage::postgres::MappingStore mappings_{*pool_};
  const storage::postgres::LinkPointStore link_points_{*pool_};
  const storage::postgres::GraphStore graphs_{*pool_};
  const storage::postgres::SiteLeaseStore site_leases_{*pool_, storage::SiteRight::kChange};
  const storage::postgres::RobotPoseStore robot_poses_{*pool_};
  const storage::postgres::RearrangementStore rearrangements_{*pool_};
};

}  // namespace

std::unique_ptr<Backend> MakePostgresBackend() { return std::make_unique<PostgresBackend>(); }

}  // namespace enfilade::testing
