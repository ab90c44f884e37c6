// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <utility>

#include "absl/types/span.h"
#include "storage/postgres/driver/result.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/sessions/session_growth.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage::postgres {

// The columns that ReadSession reads, of sessions `s` with their checkpoint `c`.
#define ENFILADE_SESSION_COLUMNS                                                                            \
  "s.site_id, s.session_id, s.robot_id, s.map_id, s.state, s.acknowledged_sequence, s.highest_sequence,"    \
  " coalesce(c.mapped_sequence, 0), s.laser_scans, s.odometry, s.images, s.point_clouds, s.withheld,"       \
  " s.door_reports,"                                                                                        \
  " coalesce(c.paired, 0), coalesce(c.unpaired, 0), coalesce(c.time_reversed, 0), coalesce(c.used, 0),"     \
  " coalesce(c.keyframes, 0), coalesce(c.lost, 0), s.payload_bytes, s.first_time_ns, s.last_time_ns,"       \
  " coalesce(s.error, ''), s.records_deleted, s.doors_judged, s.surveyed, s.create_time, s.finish_time,"    \
  " s.previous_session_id, s.initial_x, s.initial_y, s.initial_yaw, coalesce(s.initial_covariance, '{}'), " \
  "s.initial_odom_x, "                                                                                      \
  "s.initial_odom_y,"                                                                                       \
  " s.initial_odom_yaw"
#define ENFILADE_SESSION_TABLES \
  "enfilade.sessions s LEFT JOIN enfilade.mapping_checkpoints c USING (site_id, session_id)"

constexpr Statement kSessionExists{
    "looking for the session",
    "SELECT true FROM enfilade.sessions WHERE site_id = $1 AND session_id = $2 AND delete_time IS NULL"};

Session ReadSession(Row& row);

// Queues the change of rows that the transaction has locked.
void QueueGrowth(Transaction& transaction, const SiteId& site,
                 absl::Span<const std::pair<std::string_view, const SessionGrowth*>> growths);

}  // namespace enfilade::storage::postgres
