// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "core/base/ids.h"
#include "core/geometry/pose2.h"
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

namespace enfilade::testing {

// One implementation of the stores over data of its own, as the contract tests see it.
class Backend {
 public:
  virtual ~Backend() = default;

  virtual const storage::MapStore& maps() const = 0;
  virtual const storage::RevisionStore& revisions() const = 0;
  virtual const storage::SessionStore& sessions() const = 0;
  virtual const storage::RecordStore& records() const = 0;
  virtual const storage::BlobStore& blobs() const = 0;
  virtual const storage::MappingStore& mappings() const = 0;
  virtual const storage::LinkPointStore& link_points() const = 0;
  virtual const storage::GraphStore& graphs() const = 0;
  virtual const storage::SiteLeaseStore& site_leases() const = 0;
  virtual const storage::RobotPoseStore& robot_poses() const = 0;
  virtual const storage::RearrangementStore& rearrangements() const = 0;

  // What none of these stores writes.
  virtual void AddSite(const SiteId& site) = 0;
  virtual void AddRobot(const SiteId& site, const RobotId& robot) = 0;
  virtual void EnterMap(const SiteId& site, const SessionId& session, const MapId& map,
                        const PoseWithCovariance& T_map_robot) = 0;
  virtual void ExpireRecords(const SiteId& site, const SessionId& session) = 0;
  virtual void CorruptRecord(const SiteId& site, const SessionId& session, std::int64_t sequence) = 0;

  // Over all sites.
  virtual std::int64_t CountBlobs() const = 0;
  virtual std::int64_t CountRecords() const = 0;
  virtual std::int64_t CountRevisions() const = 0;
};

std::unique_ptr<Backend> MakePostgresBackend();  // in a database of its own
std::unique_ptr<Backend> MakeInMemoryBackend();

// Each program that links the suite defines this, for the implementation that it tests.
std::unique_ptr<Backend> MakeBackend();

}  // namespace enfilade::testing
