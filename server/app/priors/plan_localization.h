// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/prior/alignment/control_pairs.h"
#include "core/prior/localization/mapped_drive.h"
#include "core/prior/localization/plan_field.h"
#include "core/prior/localization/plan_localizer.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/slam_options.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/prior_map_store.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// By what a robot is located in a plan: by its scans or by a session.
struct PlanLocalizationQuery {
  std::vector<sensor::PairedScan> scans;  // numbered 1, 2, ... in order of time
  std::optional<SessionId> session;       // of the plan's site
  // Points of the plan, in the odometry frame of the scans or in the frame of the session's map. Empty: the robot may
  // be anywhere. `point_sheet`: as people pick it (prior::ToSheet).
  std::vector<prior::ControlPair> pairs;
};

// One place where the robot may be, at the last scan.
struct RobotInPlan {
  prior::PlanMode mode;
  Eigen::Vector2d point_sheet;
  double metres_per_unit = 0;                       // of the sheet, there
  std::optional<PoseWithCovariance> T_world_robot;  // unset: the plan is not placed, or is mirrored otherwise
};

struct PlanLocalizationAnswer {
  bool confident = false;
  std::vector<RobotInPlan> modes;         // the heaviest first, kMostModes at most
  std::string reason;                     // for people
  double travelled = 0;                   // m, from the first keyframe to the last
  std::optional<double> confident_after;  // m
  double matched = 0;                     // as in prior::PlanPosterior
  int keyframes = 0;
  double metres_per_unit = 0;      // of the sheet, as in prior::PlanField
  double axis = 0;                 // rad
  std::int64_t graph_version = 0;  // of the alignment that T_world_robot is by; 0: the plan is not placed
};

// Locates robots in stored plans, whatever the plan's state (core/prior/localization). Nothing is stored. Thread-safe;
// each call computes for seconds.
class PlanLocalization {
 public:
  static constexpr std::size_t kMostModes = 5;
  static constexpr std::size_t kMostKeyframes = 500;  // of a session: the last ones

  struct Stores {
    const storage::PriorMapStore& prior_maps;
    const storage::BlobStore& blobs;
    const storage::SessionStore& sessions;
    const storage::MappingStore& mappings;
    const storage::RecordStore& records;
  };
  // `slam`: how scans are mapped. The stores outlive it.
  PlanLocalization(const Stores& stores, const slam::SlamOptions& slam) : stores_(stores), slam_(slam) {}

  // INVALID_ARGUMENT: as prior::CheckDriveScans, pairs that determine nothing, scans that cannot be mapped; NOT_FOUND:
  // the session; FAILED_PRECONDITION: it is not mapped, its scans are deleted or it drove too short a way; a plan that
  // does not tell its scale or is too wide; DATA_LOSS. CANCELLED and DEADLINE_EXCEEDED soon after the call is.
  absl::StatusOr<PlanLocalizationAnswer> Locate(const storage::CallContext& context, const storage::PriorMap& prior_map,
                                                const PlanLocalizationQuery& query) const;

 private:
  absl::StatusOr<prior::MappedScans> MapDriveOf(const storage::CallContext& context, const SiteId& site,
                                                const PlanLocalizationQuery& query) const;
  absl::StatusOr<prior::MappedDrive> ReadLooks(const storage::CallContext& context, const SiteId& site,
                                               const SessionId& session,
                                               const std::vector<slam::SlamNode>& nodes) const;
  absl::StatusOr<prior::MappedScans> ReadSession(const storage::CallContext& context, const SiteId& site,
                                                 const SessionId& session, double least_distance) const;

  const Stores stores_;
  const slam::SlamOptions slam_;
};

}  // namespace enfilade::server
