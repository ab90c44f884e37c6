// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/slam/mapper/log_mapper.h"
#include "core/slam/slam_profiles.h"
#include "server/app/mapping/layer_overlay.h"
#include "server/app/mapping/session_location.h"
#include "storage/graph/robot_pose_store.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/map_store.h"
#include "storage/maps/revision_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

struct SessionMappingStores {
  const storage::MappingStore& mappings;
  const storage::RecordStore& records;
  const storage::SessionStore& sessions;
  const storage::BlobStore& blobs;
  const storage::RevisionStore& revisions;
  const storage::RobotPoseStore& robot_poses;
  const storage::MapReader& maps;
};

struct SessionMappingOptions {
  sensor::ScanPairingOptions pairing;
  slam::SlamProfiles slam;  // a map without a profile uses the one of its environment
  std::chrono::duration<double> checkpoint_interval{5.0};
  std::chrono::duration<double> revision_interval{20.0};
};

// Maps one session: reads its records in order, maps them, and stores results together with the checkpoint. The
// published revision is the session's raster between the other layers of its map. A session that enters an existing map
// continues in it (Mapper, ExistingMap); without an entry pose, the robot is located in it first (SessionLocation), and
// nothing is stored before. Each commit also stores the robot's present pose, unless the robot is lost or
// has reported a later pose. Not thread-safe; used by the thread that holds the session's lease.
class SessionMapping {
 public:
  // Resumes from the stored checkpoint, or starts at the beginning of the log, with the map's current revision, if
  // there is one, as the existing map. `session` must have a map. DATA_LOSS if the stored state does not fit this
  // program.
  static absl::StatusOr<std::unique_ptr<SessionMapping>> Load(const SessionMappingStores& stores,
                                                              const SessionMappingOptions& options,
                                                              const storage::Session& session);

  enum class Progress {
    kWorked,   // there may be more to do
    kWaiting,  // all stored records are mapped; more may come
    kEnded,    // the session is completely mapped, and stored as such
  };

  // Maps the next portion of the log, and commits if a checkpoint is due. ABORTED if the lease is lost.
  // FAILED_PRECONDITION: the robot cannot be located in the existing map. After any error, discard the object: the next
  // one resumes from the checkpoint.
  absl::StatusOr<Progress> Step(const storage::SessionLease& lease);
  // Commits what is not stored yet.
  absl::Status Store(const storage::SessionLease& lease);
  // The same once a checkpoint is due. Until then only the robot's pose is stored: writing a checkpoint takes about
  // as long as mapping a scan.
  absl::Status StoreIfDue(const storage::SessionLease& lease);

  // Marks the session as failed with `error`. Its records and results stay.
  static absl::Status Fail(const SessionMappingStores& stores, const storage::LeasedSession& leased,
                           const absl::Status& error);

  std::int64_t stored_sequence() const { return stored_sequence_; }
  bool stored() const { return mapped_sequence_ == stored_sequence_; }
  // Something is not stored, and was to be by now.
  bool overdue() const;
  // All records up to it have been read: to map them, or to locate the robot by them.
  std::int64_t read_sequence() const { return location_ ? looked_sequence_ : mapped_sequence_; }
  bool ended() const { return ended_; }
  // Memory held, about.
  std::size_t bytes() const;
  slam::LogMapperCounts counts() const { return mapper_ ? mapper_->counts() : slam::LogMapperCounts(); }

 private:
  SessionMapping(const SessionMappingStores& stores, const SessionMappingOptions& options,
                 const storage::Session& session, slam::SlamOptions slam);

  // At the beginning of the log: begins to map, or to locate the robot.
  absl::Status Begin(const storage::Session& session);
  absl::StatusOr<Progress> LocateStep();
  // The log's next portion after `sequence`; empty at its end.
  absl::StatusOr<std::vector<sensor::Record>> ReadAfter(std::int64_t sequence) const;
  absl::StatusOr<Progress> AtEndOfLog(const storage::SessionLease& lease);
  absl::Status Commit(const storage::SessionLease& lease, bool with_revision,
                      std::optional<storage::SessionState> final_state);
  // The other layers of the map, old ones in runs.
  absl::StatusOr<storage::LayersBeside> ReadLayersBeside(double resolution) const;
  absl::Status CommitRevision(const storage::SessionLease& lease, const grid::OccupancyGrid& own,
                              storage::MappingStep& step);
  void StorePose() const;

  const SessionMappingStores stores_;
  const SessionMappingOptions options_;
  const SiteId site_;
  const SessionId session_;
  const RobotId robot_;
  const MapId map_;
  const slam::SlamOptions slam_;
  LayerOverlay overlay_;
  std::optional<SessionLocation> location_;  // until the robot is located; then
  std::optional<slam::LogMapper> mapper_;
  std::int64_t looked_sequence_ = 0;  // of location_
  std::int64_t mapped_sequence_ = 0;
  std::int64_t stored_sequence_ = 0;
  bool ended_ = false;
  std::set<std::string> stored_tiles_;  // SHA-256 of the tiles of the last revision and layer
  std::chrono::steady_clock::time_point last_commit_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_revision_ = std::chrono::steady_clock::now();
};

}  // namespace enfilade::server
