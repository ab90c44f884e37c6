// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "storage/postgres/graph/site_lease_store.h"
#include "storage/postgres/rearrange/rearrangement_store.h"
#include "tests/contract/storage/store_test.h"
#include "tests/contract/storage/suite/rearrangement_fixture.h"

namespace enfilade::testing {

class PostgresRearrangementStores : public StoreTest {
 protected:
  const storage::postgres::SiteLeaseStore leases_{*pool_, storage::SiteRight::kChange};
  const storage::postgres::RearrangementStore store_{*pool_};
};

// With what no interface of the suite shows: verdicts, tracks, and all rows of the tables.
class RearrangementRowsTest : public RearrangementFixture<PostgresRearrangementStores> {
 protected:
  RearrangementRowsTest() { Judge(); }

  // s1's passage into the lab.
  void Judge() {
    database_.Sql(
        "INSERT INTO door_verdicts (site_id, session_id, sequence, decision, map_id, x, y, yaw, covariance, evidence,"
        " reason, graph_version) VALUES ('campus', 's1', 3, 5, 'lab', 0.5, 0.25, 0.3, '{1,0,0,0,2,0,0,0,3}', '{}', '', "
        "1)");
  }

  // Everything that a rearrangement may change, row by row.
  std::string AllRows() {
    std::string all;
    for (const char* query : {
             "SELECT map_id, display_name, redirect_map_id FROM maps",
             "SELECT map_id, x, y, yaw, covariance FROM graph_maps",
             "SELECT session_id, acknowledged_sequence, highest_sequence, laser_scans, odometry, payload_bytes,"
             " first_time_ns, last_time_ns, recorded_sequence, previous_session_id FROM sessions WHERE delete_time IS "
             "NULL",
             "SELECT session_id, sequence, time_ns, kind FROM session_records",
             "SELECT session_id, mapped_sequence, used, keyframes FROM mapping_checkpoints",
             "SELECT session_id, sequence, ordinal FROM door_comparisons",
             "SELECT session_id, map_id, state, initial_x, initial_y, initial_yaw, initial_covariance FROM sessions"
             " WHERE delete_time IS NULL",
             "SELECT session_id, submap_id, x, y, yaw, content FROM slam_submaps",
             "SELECT session_id, node_id, x, y, yaw, covariance FROM slam_nodes",
             "SELECT session_id, sequence, node_id, x, y, yaw FROM trajectory_points",
             "SELECT session_id, closure_id, x, y, yaw, state FROM slam_closures",
             "SELECT session_id, map_id, track::text FROM session_tracks",
             "SELECT session_id, sequence, map_id, x, y, yaw, covariance FROM door_verdicts",
             "SELECT robot_id, map_id, point::text, yaw, covariance FROM robot_poses",
             "SELECT ordinal, map_id, x, y FROM control_points",
             "SELECT link_point_id, kind, tag, direction_map_id, anchor_count, position::text, yaw FROM link_points",
             "SELECT link_point_id, map_id, ordinal, x, y, yaw, covariance FROM link_point_anchors",
             "SELECT link_point_id, map_id, kind, ordinal, sha256, x, y, yaw FROM link_point_evidence",
             "SELECT a.map_id, a.area_id, a.outline::text, to_jsonb(a) FROM map_areas a",
             "SELECT map_id, position, session_id, revision, raster_header FROM map_layers",
             "SELECT map_id, position, tile_row, tile_column, sha256 FROM map_layer_tiles",
             "SELECT map_id, content_sha256 FROM map_revisions JOIN maps USING (site_id, map_id)"
             " WHERE revision = current_revision",
         }) {
      all += std::string(query) + "\n";
      for (const std::string& row :
           database_.Sql("SELECT (q.*)::text FROM (" + std::string(query) + ") q ORDER BY 1")) {
        all += "  " + row + "\n";
      }
    }
    return all;
  }
};

}  // namespace enfilade::testing
