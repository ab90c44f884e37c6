// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/ingest/stream_messages.h"

#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::server {

v1::StreamRecordsResponse ToResponse(const Refusal& refusal) {
  v1::StreamRecordsResponse response;
  v1::BatchRefused& out = *response.mutable_refused();
  out.set_first_sequence(refusal.first_sequence);
  out.set_sequence(refusal.sequence);
  out.set_message(refusal.message);
  switch (refusal.reason) {
    case Refusal::Reason::kInvalidRecord:
      out.set_reason(v1::BatchRefused::REASON_INVALID_RECORD);
      break;
    case Refusal::Reason::kConflictingRecord:
      out.set_reason(v1::BatchRefused::REASON_CONFLICTING_RECORD);
      break;
    case Refusal::Reason::kInvalidBatch:
      out.set_reason(v1::BatchRefused::REASON_INVALID_BATCH);
      break;
  }
  return response;
}

absl::StatusOr<storage::RobotPose> ReadPoseReport(const v1::PoseReport& report) {
  storage::RobotPose pose;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName map, convert::ParseMapName("pose_report.map", report.map()));
  pose.site = map.site;
  pose.map = map.map;
  ENFILADE_ASSIGN_OR_RETURN(pose.T_map_robot,
                            enfilade::convert::FromProto("pose_report.pose_map_robot", report.pose_map_robot()));
  ENFILADE_ASSIGN_OR_RETURN(pose.time, convert::FromTimestamp(report.time()));
  return pose;
}

}  // namespace enfilade::server
