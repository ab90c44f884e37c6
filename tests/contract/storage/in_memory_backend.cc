// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/suite/backend.h"
#include "tests/fakes/in_memory_stores.h"

namespace enfilade::testing {
namespace {

class InMemoryBackend final : public Backend {
 public:
  const storage::MapStore& maps() const override { return stores_.maps; }
  const storage::RevisionStore& revisions() const override { return stores_.revisions; }
  const storage::SessionStore& sessions() const override { return stores_.sessions; }
  const storage::RecordStore& records() const override { return stores_.records; }
  const storage::BlobStore& blobs() const override { return stores_.blobs; }
  const storage::MappingStore& mappings() const override { return stores_.mappings; }
  const storage::LinkPointStore& link_points() const override { return stores_.link_points; }
  const storage::GraphStore& graphs() const override { return stores_.graphs; }
  const storage::SiteLeaseStore& site_leases() const override { return stores_.site_leases; }
  const storage::RobotPoseStore& robot_poses() const override { return stores_.robot_poses; }
  const storage::RearrangementStore& rearrangements() const override { return stores_.rearrangements; }

  void AddSite(const SiteId& site) override { stores_.database.AddSite(site); }
  void AddRobot(const SiteId& site, const RobotId& robot) override { stores_.database.AddRobot(site, robot); }
  void EnterMap(const SiteId& site, const SessionId& session, const MapId& map,
                const PoseWithCovariance& T_map_robot) override {
    stores_.database.EnterMap(site, session, map, T_map_robot);
  }
  void ExpireRecords(const SiteId& site, const SessionId& session) override {
    stores_.database.ExpireRecords(site, session);
  }
  void CorruptRecord(const SiteId& site, const SessionId& session, std::int64_t sequence) override {
    stores_.database.CorruptRecord(site, session, sequence);
  }

  std::int64_t CountBlobs() const override { return stores_.database.CountBlobs(); }
  std::int64_t CountRecords() const override { return stores_.database.CountRecords(); }
  std::int64_t CountRevisions() const override { return stores_.database.CountRevisions(); }

 private:
  InMemoryStores stores_;
};

}  // namespace

std::unique_ptr<Backend> MakeInMemoryBackend() { return std::make_unique<InMemoryBackend>(); }

}  // namespace enfilade::testing
