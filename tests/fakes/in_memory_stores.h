// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/graph/graph_store.h"
#include "storage/graph/link_point_store.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/graph/robot_pose_store.h"
#include "storage/graph/site_lease_store.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"
#include "tests/fakes/in_memory_database.h"

namespace enfilade::testing {

// The stores of storage/ over an InMemoryDatabase, which must outlive them. They pass the same contract tests as the
// PostgreSQL stores (tests/contract/storage/suite).

class InMemoryMapStore final : public storage::MapStore {
 public:
  explicit InMemoryMapStore(InMemoryDatabase& database) : database_(database) {}

  absl::StatusOr<storage::Map> Create(const storage::CallContext& context, const storage::Map& map,
                                      const storage::RequestId& request_id) const override;
  absl::StatusOr<storage::Map> Get(const storage::CallContext& context, const SiteId& site,
                                   const MapId& map) const override;
  absl::StatusOr<storage::Map> GetByDisplayName(const storage::CallContext& context, const SiteId& site,
                                                const std::string& display_name) const override;
  absl::StatusOr<std::vector<storage::Map>> List(const storage::CallContext& context, const SiteId& site,
                                                 const storage::PageRequest& page) const override;
  absl::StatusOr<storage::Map> Update(const storage::CallContext& context, const storage::Map& map) const override;
  absl::Status Delete(const storage::CallContext& context, const SiteId& site, const MapId& map, std::int64_t etag,
                      bool force) const override;

 private:
  InMemoryDatabase& database_;
};

class InMemorySessionStore final : public storage::SessionStore {
 public:
  explicit InMemorySessionStore(InMemoryDatabase& database) : database_(database) {}

  absl::StatusOr<storage::Session> Create(const storage::CallContext& context, const storage::Session& session,
                                          const storage::RequestId& request_id) const override;
  absl::StatusOr<storage::Session> Get(const storage::CallContext& context, const SiteId& site,
                                       const SessionId& session) const override;
  absl::StatusOr<std::vector<storage::Session>> List(
      const storage::CallContext& context, const SiteId& site, const storage::SessionFilter& filter, int limit,
      const std::optional<storage::SessionPosition>& after) const override;
  absl::StatusOr<storage::Session> Finish(const storage::CallContext& context, const SiteId& site,
                                          const SessionId& session, std::int64_t last_sequence) const override;
  absl::StatusOr<storage::ClosedSessions> CloseIdle(const storage::CallContext& context, std::chrono::seconds idle,
                                                    std::int64_t limit) const override;
  absl::Status Delete(const storage::CallContext& context, const SiteId& site, const SessionId& session) const override;

 private:
  InMemoryDatabase& database_;
};

class InMemoryRecordStore final : public storage::RecordStore {
 public:
  explicit InMemoryRecordStore(InMemoryDatabase& database) : database_(database) {}

  std::vector<absl::StatusOr<storage::AppendResult>> AppendGroup(
      const storage::CallContext& context, absl::Span<const storage::RecordBatch> batches) const override;
  absl::StatusOr<std::vector<sensor::Record>> Read(const storage::CallContext& context, const SiteId& site,
                                                   const SessionId& session, std::int64_t from_sequence,
                                                   std::int64_t max_bytes) const override;
  absl::StatusOr<std::vector<sensor::Record>> ReadSelected(const storage::CallContext& context, const SiteId& site,
                                                           const SessionId& session,
                                                           const storage::RecordSelection& selection) const override;
  absl::StatusOr<std::vector<sensor::Record>> ReadEach(const storage::CallContext& context, const SiteId& site,
                                                       const SessionId& session,
                                                       const std::vector<std::int64_t>& sequences) const override;

 private:
  InMemoryDatabase& database_;
};

class InMemoryBlobStore final : public storage::BlobStore {
 public:
  explicit InMemoryBlobStore(InMemoryDatabase& database) : database_(database) {}

  absl::Status Put(const storage::CallContext& context, const SiteId& site,
                   absl::Span<const storage::BlobView> blobs) const override;
  absl::StatusOr<std::string> Get(const storage::CallContext& context, const SiteId& site,
                                  std::string_view sha256) const override;

 private:
  InMemoryDatabase& database_;
};

class InMemoryRevisionStore final : public storage::RevisionStore {
 public:
  explicit InMemoryRevisionStore(InMemoryDatabase& database) : database_(database) {}

  absl::StatusOr<storage::MapRevision> Add(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                           const storage::NewRevision& revision,
                                           absl::Span<const storage::BlobView> blobs) const override;
  absl::StatusOr<storage::MapRevision> Get(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                           std::int64_t number) const override;
  absl::StatusOr<std::vector<storage::MapRevision>> List(const storage::CallContext& context, const SiteId& site,
                                                         const MapId& map, std::int64_t before,
                                                         int limit) const override;
  absl::StatusOr<storage::MapRevision> Tag(const storage::CallContext& context, const SiteId& site, const MapId& map,
                                           std::int64_t number, const std::string& tag) const override;
  absl::StatusOr<storage::LayersBeside> ReadLayersBeside(const storage::CallContext& context, const SiteId& site,
                                                         const MapId& map, const SessionId& session) const override;
  absl::StatusOr<storage::LayersBeside> ReadRunsBeside(const storage::CallContext& context, const SiteId& site,
                                                       const MapId& map, const SessionId& session,
                                                       double resolution) const override;
  absl::Status AddRun(const storage::CallContext& context, const SiteId& site, const MapId& map,
                      const storage::NewLayerRun& run) const override;
  absl::StatusOr<storage::OrphanedLayers> ReadOrphanedLayers(const storage::CallContext& context, const SiteId& site,
                                                             const MapId& map, int least, int limit) const override;
  absl::Status MergeLayers(const storage::CallContext& context, const SiteId& site, const MapId& map,
                           const storage::NewLayerRun& merged) const override;
  absl::StatusOr<std::vector<storage::Tile>> ReadTiles(const storage::CallContext& context,
                                                       const storage::MapRevision& revision,
                                                       std::optional<storage::TileKey> after,
                                                       std::int64_t max_bytes) const override;

 private:
  InMemoryDatabase& database_;
};

class InMemoryMappingStore final : public storage::MappingStore {
 public:
  explicit InMemoryMappingStore(InMemoryDatabase& database) : database_(database) {}

  absl::StatusOr<std::optional<storage::LeasedSession>> Acquire(const storage::CallContext& context,
                                                                const std::string& owner,
                                                                std::chrono::milliseconds ttl) const override;
  absl::Status Renew(const storage::CallContext& context, const storage::SessionLease& lease,
                     std::chrono::milliseconds ttl) const override;
  absl::Status Release(const storage::CallContext& context, const storage::SessionLease& lease,
                       std::int64_t read_sequence) const override;
  absl::Status Queue(const storage::CallContext& context, const SiteId& site, const SessionId& session) const override;
  absl::StatusOr<storage::MappingBacklog> GetBacklog(const storage::CallContext& context) const override;
  absl::StatusOr<std::int64_t> Commit(const storage::CallContext& context, const storage::SessionLease& lease,
                                      const storage::MappingStep& step) const override;
  absl::StatusOr<std::optional<storage::StoredMapping>> Load(const storage::CallContext& context, const SiteId& site,
                                                             const SessionId& session) const override;
  absl::StatusOr<storage::Trajectory> ReadTrajectory(const storage::CallContext& context, const SiteId& site,
                                                     const SessionId& session) const override;
  absl::StatusOr<std::vector<slam::SlamNode>> ListKeyframes(const storage::CallContext& context, const SiteId& site,
                                                            const SessionId& session) const override;
  absl::StatusOr<std::optional<PoseWithCovariance>> FindKeyframe(const storage::CallContext& context,
                                                                 const SiteId& site, const SessionId& session,
                                                                 TimeNs time) const override;

 private:
  InMemoryDatabase& database_;
};

class InMemoryLinkPointStore final : public storage::LinkPointStore {
 public:
  explicit InMemoryLinkPointStore(InMemoryDatabase& database) : database_(database) {}

  absl::StatusOr<storage::StoredLinkPoint> Create(const storage::CallContext& context,
                                                  const storage::StoredLinkPoint& link_point,
                                                  const storage::RequestId& request_id) const override;
  absl::StatusOr<storage::StoredLinkPoint> AddAnchor(const storage::CallContext& context, const SiteId& site,
                                                     const storage::NewAnchor& added) const override;
  absl::StatusOr<storage::StoredLinkPoint> Get(const storage::CallContext& context, const SiteId& site,
                                               const LinkPointId& id) const override;
  absl::StatusOr<std::vector<storage::StoredLinkPoint>> List(const storage::CallContext& context, const SiteId& site,
                                                             const storage::LinkPointFilter& filter,
                                                             const storage::PageRequest& page) const override;
  absl::StatusOr<storage::StoredLinkPoint> Update(const storage::CallContext& context,
                                                  const storage::StoredLinkPoint& link_point) const override;
  absl::StatusOr<storage::StoredLinkPoint> SetSuspended(const storage::CallContext& context, const SiteId& site,
                                                        const LinkPointId& id, std::int64_t etag,
                                                        bool suspended) const override;
  absl::Status Delete(const storage::CallContext& context, const SiteId& site, const LinkPointId& id,
                      std::int64_t etag) const override;
  absl::StatusOr<storage::ChangedLinkPoints> Change(
      const storage::CallContext& context, const SiteId& site,
      const std::vector<storage::LinkPointChange>& changes) const override;
  absl::StatusOr<storage::FoundLinkPoints> Find(const storage::CallContext& context, const SiteId& site,
                                                const storage::LinkPointQuery& query) const override;
  absl::StatusOr<std::vector<storage::StoredLinkPoint>> ListUnplaced(const storage::CallContext& context,
                                                                     const SiteId& site, int limit) const override;
  absl::Status PutEvidence(const storage::CallContext& context, const SiteId& site,
                           const storage::Evidence& evidence) const override;
  absl::StatusOr<std::vector<storage::Evidence>> ListEvidence(
      const storage::CallContext& context, const SiteId& site,
      const std::vector<LinkPointId>& link_points) const override;

 private:
  InMemoryDatabase& database_;
};

class InMemoryGraphStore final : public storage::GraphStore {
 public:
  explicit InMemoryGraphStore(InMemoryDatabase& database) : database_(database) {}

  absl::StatusOr<std::int64_t> GetVersion(const storage::CallContext& context, const SiteId& site) const override;
  absl::StatusOr<storage::GraphChanges> ReadChanges(const storage::CallContext& context, const SiteId& site,
                                                    std::int64_t since) const override;
  absl::StatusOr<std::int64_t> Apply(const storage::CallContext& context, const SiteId& site, std::int64_t version,
                                     const storage::GraphSolution& solution) const override;
  absl::StatusOr<std::int64_t> SolveHeld(
      const storage::CallContext& context, const SiteId& site, std::int64_t since,
      const std::function<absl::StatusOr<storage::GraphSolution>(const storage::GraphChanges&)>& solve) const override;
  absl::StatusOr<std::vector<storage::GraphVersion>> ListVersions(const storage::CallContext& context,
                                                                  const SiteId& site, std::int64_t before,
                                                                  int limit) const override;
  absl::StatusOr<std::int64_t> FindLastOptimization(const storage::CallContext& context, const SiteId& site,
                                                    std::int64_t since) const override;
  absl::StatusOr<storage::MapPoseChanges> GetMapPoses(const storage::CallContext& context, const SiteId& site,
                                                      std::int64_t version, std::int64_t since) const override;
  absl::StatusOr<std::vector<storage::MapPose>> GetPlaces(const storage::CallContext& context, const SiteId& site,
                                                          const std::vector<MapId>& maps) const override;
  absl::StatusOr<std::int64_t> SetControlPoints(const storage::CallContext& context, const SiteId& site,
                                                const std::vector<storage::ControlPoint>& points) const override;
  absl::StatusOr<std::vector<storage::ControlPoint>> GetControlPoints(const storage::CallContext& context,
                                                                      const SiteId& site) const override;
  // None: prior maps have no store in memory.
  absl::StatusOr<std::vector<storage::StoredPlanTies>> ReadPlanTies(
      const storage::CallContext& context, const SiteId& site, const std::vector<std::string>& known) const override;
  absl::StatusOr<std::vector<storage::GraphListener::Change>> ListVersionsOf(
      const storage::CallContext& context, const std::vector<SiteId>& sites) const override;
  absl::StatusOr<std::unique_ptr<storage::GraphListener>> Listen(const storage::CallContext& context) const override;

 private:
  InMemoryDatabase& database_;
};

class InMemorySiteLeaseStore final : public storage::SiteLeaseStore {
 public:
  InMemorySiteLeaseStore(InMemoryDatabase& database, storage::SiteRight right) : database_(database), right_(right) {}

  absl::StatusOr<std::optional<storage::SiteLease>> Acquire(const storage::CallContext& context, const SiteId& site,
                                                            const std::string& owner,
                                                            std::chrono::milliseconds ttl) const override;
  absl::Status Renew(const storage::CallContext& context, const storage::SiteLease& lease,
                     std::chrono::milliseconds ttl) const override;
  absl::Status Release(const storage::CallContext& context, const storage::SiteLease& lease) const override;

 private:
  LeaseRow& LeaseOf(SiteRows& rows) const;

  InMemoryDatabase& database_;
  const storage::SiteRight right_;
};

class InMemoryRobotPoseStore final : public storage::RobotPoseStore {
 public:
  explicit InMemoryRobotPoseStore(InMemoryDatabase& database) : database_(database) {}

  std::vector<absl::Status> ReportAll(const storage::CallContext& context,
                                      const std::vector<storage::RobotPose>& poses) const override;
  absl::StatusOr<storage::RobotPose> Get(const storage::CallContext& context, const SiteId& site,
                                         const RobotId& robot) const override;
  absl::StatusOr<std::vector<storage::RobotPose>> List(const storage::CallContext& context,
                                                       const SiteId& site) const override;

 private:
  absl::Status ReportOne(const storage::CallContext& context, const storage::RobotPose& report) const;

  InMemoryDatabase& database_;
};

class InMemoryRearrangementStore final : public storage::RearrangementStore {
 public:
  explicit InMemoryRearrangementStore(InMemoryDatabase& database) : database_(database) {}

  absl::StatusOr<storage::StoredRearrangement> Apply(const storage::CallContext& context,
                                                     const storage::SiteLease& lease,
                                                     const storage::RearrangementChange& change) const override;
  absl::StatusOr<storage::StoredRearrangement> Undo(const storage::CallContext& context,
                                                    const storage::SiteLease& lease,
                                                    const rearrange::RearrangementId& id) const override;
  absl::StatusOr<rearrange::MapRedirect> Resolve(const storage::CallContext& context, const SiteId& site,
                                                 const MapId& map) const override;
  absl::StatusOr<storage::StoredRearrangement> Get(const storage::CallContext& context, const SiteId& site,
                                                   const rearrange::RearrangementId& id) const override;
  absl::StatusOr<std::vector<storage::StoredRearrangement>> List(const storage::CallContext& context,
                                                                 const SiteId& site, std::int64_t before,
                                                                 int limit) const override;

 private:
  InMemoryDatabase& database_;
};

// All of them over one database.
struct InMemoryStores {
  InMemoryDatabase database;
  InMemoryMapStore maps{database};
  InMemorySessionStore sessions{database};
  InMemoryRecordStore records{database};
  InMemoryBlobStore blobs{database};
  InMemoryRevisionStore revisions{database};
  InMemoryMappingStore mappings{database};
  InMemoryLinkPointStore link_points{database};
  InMemoryGraphStore graphs{database};
  InMemorySiteLeaseStore site_leases{database, storage::SiteRight::kChange};
  InMemorySiteLeaseStore solver_leases{database, storage::SiteRight::kSolve};
  InMemoryRobotPoseStore robot_poses{database};
  InMemoryRearrangementStore rearrangements{database};
};

}  // namespace enfilade::testing
