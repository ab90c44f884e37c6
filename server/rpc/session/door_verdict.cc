// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/session/door_verdict.h"

#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::server {
namespace {

static_assert(static_cast<int>(closure::DoorDecision::kNotJudged) == v1::DoorVerdict::DECISION_NOT_JUDGED);

v1::DoorComparison ToProto(const SiteId& site, const closure::DoorComparison& comparison) {
  v1::DoorComparison out;
  out.set_link_point(convert::NameOf(convert::LinkPointName{site, comparison.link_point}));
  out.set_map(convert::NameOf(convert::MapName{site, comparison.map}));
  out.set_distance_m(comparison.distance.value_or(-1.0));
  out.set_image_matches(comparison.image_matches.value_or(-1));
  out.set_images_agree(comparison.images_agree);
  out.set_registration_rmse_m(comparison.rmse.value_or(-1.0));
  out.set_registration_inlier_share(comparison.inlier_share);
  out.set_clouds_agree(comparison.clouds_agree);
  out.set_chi2(comparison.chi2.value_or(-1.0));
  out.set_accepted(comparison.accepted);
  out.set_reason(comparison.reason);
  return out;
}

}  // namespace

v1::DoorVerdict ToProto(const SiteId& site, const closure::DoorVerdict& verdict) {
  v1::DoorVerdict out;
  out.set_name(convert::NameOf(convert::DoorVerdictName{site, verdict.session, verdict.sequence}));
  out.set_decision(static_cast<v1::DoorVerdict::Decision>(verdict.decision));
  if (verdict.link_point) out.set_link_point(convert::NameOf(convert::LinkPointName{site, *verdict.link_point}));
  if (verdict.entered_map) out.set_entered_map(convert::NameOf(convert::MapName{site, *verdict.entered_map}));
  if (verdict.T_map_robot) *out.mutable_pose_map_robot() = enfilade::convert::ToProto(*verdict.T_map_robot);
  for (const closure::DoorComparison& comparison : verdict.comparisons)
    *out.add_comparisons() = ToProto(site, comparison);
  out.set_reason(verdict.reason);
  out.set_graph_version(verdict.graph_version);
  *out.mutable_create_time() = convert::ToTimestamp(verdict.create_time);
  return out;
}

v1::MapEntered ToProto(const MapEntry& entry) {
  v1::MapEntered out;
  out.set_map(convert::NameOf(convert::MapName{entry.map.site, entry.map.id}));
  out.set_map_display_name(entry.map.display_name);
  if (entry.entry.T_map_robot) *out.mutable_pose_map_robot() = enfilade::convert::ToProto(*entry.entry.T_map_robot);
  if (entry.entry.T_odom_robot) *out.mutable_pose_odom_robot() = enfilade::convert::ToProto(*entry.entry.T_odom_robot);
  if (entry.verdict) *out.mutable_verdict() = ToProto(entry.map.site, *entry.verdict);
  return out;
}

}  // namespace enfilade::server
