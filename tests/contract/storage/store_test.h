// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "storage/postgres/graph/graph_store.h"
#include "storage/postgres/graph/link_point_store.h"
#include "storage/postgres/graph/robot_pose_store.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/map_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/sessions/mapping_store.h"
#include "storage/postgres/sessions/record_store.h"
#include "storage/postgres/sessions/session_store.h"
#include "storage/sites/audit_store.h"
#include "storage/sites/robot_store.h"
#include "storage/sites/site_deletion.h"
#include "storage/sites/site_store.h"
#include "tests/contract/storage/store_values.h"
#include "tests/support/database.h"
#include "tests/support/status_assertions.h"

namespace enfilade::testing {

// All stores over a database of the test's own, with a site "campus", a robot "r1" and a map "hall" in it.
class StoreTest : public DatabaseTest {
 protected:
  StoreTest();

  // A new session of r1 into "hall"; without `mapped` only recorded.
  SessionId NewSession(const std::string& id, bool mapped = true);
  absl::StatusOr<storage::AppendResult> Append(const SessionId& session, const std::vector<sensor::Record>& records,
                                               const std::vector<storage::BlobView>& blobs = {});
  // Deletes a site with everything that belongs to it.
  void DeleteSite(const SiteId& site);

  const SiteId site_{"campus"};
  const RobotId robot_{"r1"};
  const MapId map_{"hall"};
  storage::SiteStore sites_{*pool_};
  storage::RobotStore robots_{*pool_};
  storage::postgres::MapStore maps_{*pool_};
  storage::postgres::RevisionStore revisions_{*pool_};
  storage::postgres::SessionStore sessions_{*pool_};
  storage::postgres::RecordStore records_{*pool_};
  storage::postgres::BlobStore blobs_{*pool_};
  storage::postgres::MappingStore mapping_{*pool_};
  storage::postgres::LinkPointStore link_points_{*pool_};
  storage::postgres::GraphStore graph_{*pool_};
  storage::postgres::RobotPoseStore robot_poses_{*pool_};
  storage::AuditStore audit_{*pool_};
};

}  // namespace enfilade::testing
