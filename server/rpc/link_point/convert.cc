// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/link_point/convert.h"

#include <algorithm>
#include <map>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

constexpr std::ptrdiff_t kMaxTagCharacters = 200;

absl::Status CheckTag(const std::string& tag) {
  const auto characters =
      std::count_if(tag.begin(), tag.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
  if (characters <= kMaxTagCharacters && tag.find('\0') == std::string::npos) return absl::OkStatus();
  return InvalidArgument("link_point.tag must have at most {} characters and no NUL", kMaxTagCharacters);
}

absl::Status Unknown(const char* field, int value) {
  return InvalidArgument("{} is {}: unknown to this server", field, value);
}

}  // namespace

void ToProto(const storage::StoredLinkPoint& link_point, v1::LinkPoint& out) {
  const graph::LinkPoint& point = link_point.point;
  out.set_name(NameOf(link_point.site, point.id));
  static_assert(static_cast<int>(graph::LinkPointKind::kOpening) == v1::LinkPoint::KIND_OPENING);
  out.set_kind(static_cast<v1::LinkPoint::Kind>(point.kind));
  out.set_tag(point.tag);
  for (const graph::Anchor& anchor : point.anchors) {
    v1::Anchor& added = *out.add_anchors();
    added.set_map(NameOf(link_point.site, anchor.map));
    enfilade::convert::ToProto({anchor.T_map_place, anchor.covariance}, *added.mutable_pose_map_place());
  }
  if (!point.direction.empty()) out.set_direction_map(NameOf(link_point.site, point.direction));
  out.set_difficulty(point.difficulty);
  if (link_point.environment) out.set_environment(static_cast<v1::Map::Environment>(*link_point.environment));
  static_assert(static_cast<int>(graph::PassageState::kBlocked) == v1::LinkPoint::STATE_BLOCKED);
  out.set_state(static_cast<v1::LinkPoint::State>(point.state));
  if (point.state_valid_until) *out.mutable_state_valid_until() = convert::ToTimestamp(*point.state_valid_until);
  static_assert(static_cast<int>(graph::LinkPointUse::kSuspended) == v1::LinkPoint::USE_SUSPENDED);
  out.set_use(static_cast<v1::LinkPoint::Use>(point.use));
  if (link_point.T_world_place) enfilade::convert::ToProto(*link_point.T_world_place, *out.mutable_pose_world_place());
  out.set_forced(link_point.forced);
  out.set_pinned(point.pinned);
  out.set_graph_version(point.graph_version);
  out.set_etag(std::to_string(link_point.etag));
  *out.mutable_create_time() = convert::ToTimestamp(link_point.create_time);
  *out.mutable_update_time() = convert::ToTimestamp(link_point.update_time);
}

v1::LinkPoint ToProto(const storage::StoredLinkPoint& link_point) {
  v1::LinkPoint out;
  ToProto(link_point, out);
  return out;
}

v1::Evidence ToProto(const SiteId& site, const storage::Evidence& evidence) {
  v1::Evidence out;
  out.set_map(convert::NameOf(convert::MapName{site, evidence.map}));
  v1::BlobRef content;
  content.set_sha256(evidence.content.sha256);
  content.set_size_bytes(evidence.content.size);
  if (evidence.kind == storage::EvidenceKind::kCloud) {
    *out.mutable_cloud()->mutable_time() = convert::ToTimestamp(evidence.time);
    out.mutable_cloud()->set_encoding(static_cast<v1::PointCloud::Encoding>(evidence.encoding));
    *out.mutable_cloud()->mutable_content() = content;
    return out;
  }
  *out.mutable_image()->mutable_time() = convert::ToTimestamp(evidence.time);
  out.mutable_image()->set_camera(evidence.kind == storage::EvidenceKind::kRearImage ? v1::Image::CAMERA_REAR
                                                                                     : v1::Image::CAMERA_FRONT);
  out.mutable_image()->set_encoding(static_cast<v1::Image::Encoding>(evidence.encoding));
  *out.mutable_image()->mutable_content() = content;
  return out;
}

absl::StatusOr<MapId> MapOfSite(const std::string& field, const SiteId& site, const std::string& map) {
  ENFILADE_ASSIGN_OR_RETURN(convert::MapName name, convert::ParseMapName(field, map));
  if (name.site == site) return std::move(name.map);
  return InvalidArgument("{} is of site \"{}\", not of \"{}\": they must be the same", field, name.site.value(),
                         site.value());
}

absl::StatusOr<graph::Anchor> FromProto(const std::string& field, const SiteId& site, const v1::Anchor& in) {
  graph::Anchor anchor;
  ENFILADE_ASSIGN_OR_RETURN(anchor.map, MapOfSite(field + ".map", site, in.map()));
  ENFILADE_ASSIGN_OR_RETURN(const PoseWithCovariance place,
                            enfilade::convert::FromProto(field + ".pose_map_place", in.pose_map_place()));
  anchor.T_map_place = place.pose;
  anchor.covariance = in.pose_map_place().covariance().empty() ? graph::DefaultAnchorCovariance() : place.covariance;
  return anchor;
}

absl::StatusOr<storage::StoredLinkPoint> FromProto(const SiteId& site, const v1::LinkPoint& in) {
  storage::StoredLinkPoint out;
  out.site = site;
  graph::LinkPoint& point = out.point;
  if (!v1::LinkPoint::Kind_IsValid(in.kind())) return Unknown("link_point.kind", in.kind());
  if (!v1::LinkPoint::State_IsValid(in.state())) return Unknown("link_point.state", in.state());
  if (!v1::Map::Environment_IsValid(in.environment())) return Unknown("link_point.environment", in.environment());
  if (in.kind() != 0) point.kind = static_cast<graph::LinkPointKind>(in.kind());
  if (in.state() != 0) point.state = static_cast<graph::PassageState>(in.state());
  if (in.environment() != 0) out.environment = static_cast<Environment>(in.environment());
  ENFILADE_RETURN_IF_ERROR(CheckTag(in.tag()));
  point.tag = in.tag();
  if (in.difficulty() < 0) return InvalidArgument("link_point.difficulty is {}: expected 0 or more", in.difficulty());
  point.difficulty = in.difficulty();
  point.pinned = !in.has_pinned() || in.pinned();
  for (int i = 0; i < in.anchors_size(); ++i) {
    ENFILADE_ASSIGN_OR_RETURN(graph::Anchor anchor,
                              FromProto(fmt::format("link_point.anchors[{}]", i), site, in.anchors(i)));
    point.anchors.push_back(std::move(anchor));
  }
  if (!in.direction_map().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(point.direction, MapOfSite("link_point.direction_map", site, in.direction_map()));
  }
  if (in.has_state_valid_until()) {
    ENFILADE_ASSIGN_OR_RETURN(point.state_valid_until, convert::FromTimestamp(in.state_valid_until()));
  }
  return out;
}

absl::StatusOr<storage::Evidence> FromProto(const convert::LinkPointName& name, const v1::Evidence& in) {
  storage::Evidence out;
  out.link_point = name.link_point;
  ENFILADE_ASSIGN_OR_RETURN(out.map, MapOfSite("evidence.map", name.site, in.map()));
  // A record's image or cloud, under the same rules.
  v1::Record record;
  record.set_sequence(1);
  if (in.has_image()) *record.mutable_image() = in.image();
  if (in.has_cloud()) *record.mutable_point_cloud() = in.cloud();
  if (!in.has_image() && !in.has_cloud()) return InvalidArgument("evidence has no content: expected image or cloud");
  ENFILADE_ASSIGN_OR_RETURN(const sensor::Record read, enfilade::convert::FromProto(record));
  out.time = sensor::TimeOf(read);
  out.content = *sensor::FindBlob(read);
  if (const auto* image = std::get_if<sensor::Image>(&read.payload)) {
    out.kind =
        image->camera == sensor::Camera::kRear ? storage::EvidenceKind::kRearImage : storage::EvidenceKind::kFrontImage;
    out.encoding = static_cast<std::int16_t>(image->encoding);
  } else {
    out.kind = storage::EvidenceKind::kCloud;
    out.encoding = static_cast<std::int16_t>(std::get<sensor::PointCloud>(read.payload).encoding);
  }
  return out;
}

absl::Status CheckLinkPointMask(const google::protobuf::FieldMask& mask) {
  return CheckMask(mask, {"kind", "tag", "anchors", "direction_map", "difficulty", "environment", "state",
                          "state_valid_until", "pinned"});
}

void Overwrite(const v1::LinkPoint& from, const google::protobuf::FieldMask& mask, v1::LinkPoint& to) {
  const bool is_placed = IsUpdated(mask, "kind", from.kind() != 0) ||
                         IsUpdated(mask, "anchors", from.anchors_size() > 0) ||
                         IsUpdated(mask, "direction_map", !from.direction_map().empty());
  const bool is_pinned_given = std::find(mask.paths().begin(), mask.paths().end(), "pinned") != mask.paths().end() ||
                               (!is_placed && IsUpdated(mask, "pinned", from.has_pinned()));
  if (is_placed || is_pinned_given) to.set_pinned(!is_pinned_given || from.pinned());
  if (IsUpdated(mask, "kind", from.kind() != 0)) to.set_kind(from.kind());
  if (IsUpdated(mask, "tag", !from.tag().empty())) to.set_tag(from.tag());
  if (IsUpdated(mask, "anchors", from.anchors_size() > 0)) *to.mutable_anchors() = from.anchors();
  if (IsUpdated(mask, "direction_map", !from.direction_map().empty())) to.set_direction_map(from.direction_map());
  if (IsUpdated(mask, "difficulty", from.difficulty() != 0)) to.set_difficulty(from.difficulty());
  if (IsUpdated(mask, "environment", from.environment() != 0)) to.set_environment(from.environment());
  if (IsUpdated(mask, "state", from.state() != 0)) to.set_state(from.state());
  if (!IsUpdated(mask, "state_valid_until", from.has_state_valid_until())) return;
  to.clear_state_valid_until();
  if (from.has_state_valid_until()) *to.mutable_state_valid_until() = from.state_valid_until();
}

absl::StatusOr<std::optional<bool>> CandidatesOf(v1::LinkPointSubset subset) {
  if (!v1::LinkPointSubset_IsValid(subset)) return Unknown("subset", subset);
  if (subset == v1::LINK_POINT_SUBSET_UNSPECIFIED) return std::optional<bool>();
  return std::optional<bool>(subset == v1::LINK_POINT_SUBSET_CANDIDATES);
}

absl::StatusOr<std::vector<v1::LinkPoint>> WithEvidence(const Services& services, const storage::CallContext& context,
                                                        const SiteId& site,
                                                        const std::vector<storage::StoredLinkPoint>& link_points) {
  std::vector<LinkPointId> ids;
  std::map<LinkPointId, std::size_t> places;
  std::vector<v1::LinkPoint> out;
  for (const storage::StoredLinkPoint& link_point : link_points) {
    places[link_point.point.id] = out.size();
    ids.push_back(link_point.point.id);
    out.push_back(ToProto(link_point));
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto evidence, services.link_points.ListEvidence(context, site, ids));
  for (const storage::Evidence& item : evidence) *out[places.at(item.link_point)].add_evidence() = ToProto(site, item);
  return out;
}

absl::StatusOr<v1::LinkPoint> WithEvidence(const Services& services, const storage::CallContext& context,
                                           const storage::StoredLinkPoint& link_point) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<v1::LinkPoint> out,
                            WithEvidence(services, context, link_point.site, {link_point}));
  return std::move(out.front());
}

}  // namespace enfilade::server
