#include "server/rpc/link_point/convert.h"

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"

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

void ToProto(const StoredLinkPoint& link_point, v1::LinkPoint& out) {
  const LinkPoint& point = link_point.point;
  out.set_name(NameOf(link_point.site, point.id));
  static_assert(static_cast<int>(LinkPointKind::kOpening) == v1::LinkPoint::KIND_OPENING);
  out.set_kind(static_cast<v1::LinkPoint::Kind>(point.kind));
  out.set_tag(point.tag);
  for (const Anchor& anchor : point.anchors) {
    v1::Anchor& added = *out.add_anchors();
    added.set_map(NameOf(link_point.site, anchor.map));
    enfilade::ToProto({anchor.T_map_place, anchor.covariance}, *added.mutable_pose_map_place());
  }
  if (!point.direction.empty()) out.set_direction_map(NameOf(link_point.site, point.direction));
  out.set_difficulty(point.difficulty);
  if (link_point.environment) out.set_environment(static_cast<v1::Map::Environment>(*link_point.environment));
  static_assert(static_cast<int>(PassageState::kBlocked) == v1::LinkPoint::STATE_BLOCKED);
  out.set_state(static_cast<v1::LinkPoint::State>(point.state));
  if (point.state_valid_until) *out.mutable_state_valid_until() = ToTimestamp(*point.state_valid_until);
  static_assert(static_cast<int>(LinkPointUse::kSuspended) == v1::LinkPoint::USE_SUSPENDED);
  out.set_use(static_cast<v1::LinkPoint::Use>(point.use));
  if (link_point.T_world_place) enfilade::ToProto(*link_point.T_world_place, *out.mutable_pose_world_place());
  out.set_forced(link_point.forced);
  out.set_graph_version(point.graph_version);
  out.set_etag(std::to_string(link_point.etag));
  *out.mutable_create_time() = ToTimestamp(link_point.create_time);
  *out.mutable_update_time() = ToTimestamp(link_point.update_time);
}

v1::LinkPoint ToProto(const StoredLinkPoint& link_point) {
  v1::LinkPoint out;
  ToProto(link_point, out);
  return out;
}

v1::Evidence ToProto(const SiteId& site, const Evidence& evidence) {
  v1::Evidence out;
  out.set_map(NameOf(MapName{site, evidence.map}));
  v1::BlobRef content;
  content.set_sha256(evidence.content.sha256);
  content.set_size_bytes(evidence.content.size);
  if (evidence.kind == EvidenceKind::kCloud) {
    *out.mutable_cloud()->mutable_time() = ToTimestamp(evidence.time);
    out.mutable_cloud()->set_encoding(static_cast<v1::PointCloud::Encoding>(evidence.encoding));
    *out.mutable_cloud()->mutable_content() = content;
    return out;
  }
  *out.mutable_image()->mutable_time() = ToTimestamp(evidence.time);
  out.mutable_image()->set_camera(evidence.kind == EvidenceKind::kRearImage ? v1::Image::CAMERA_REAR
                                                                            : v1::Image::CAMERA_FRONT);
  out.mutable_image()->set_encoding(static_cast<v1::Image::Encoding>(evidence.encoding));
  *out.mutable_image()->mutable_content() = content;
  return out;
}

absl::StatusOr<MapId> MapOfSite(const std::string& field, const SiteId& site, const std::string& map) {
  ENFILADE_ASSIGN_OR_RETURN(MapName name, ParseMapName(field, map));
  if (name.site == site) return std::move(name.map);
  return InvalidArgument("{} is of site \"{}\", not of \"{}\": they must be the same", field, name.site.value(),
                         site.value());
}

absl::StatusOr<Anchor> FromProto(const std::string& field, const SiteId& site, const v1::Anchor& in) {
  Anchor anchor;
  ENFILADE_ASSIGN_OR_RETURN(anchor.map, MapOfSite(field + ".map", site, in.map()));
  ENFILADE_ASSIGN_OR_RETURN(const PoseWithCovariance place,
                            enfilade::FromProto(field + ".pose_map_place", in.pose_map_place()));
  anchor.T_map_place = place.pose;
  anchor.covariance = in.pose_map_place().covariance().empty() ? DefaultAnchorCovariance() : place.covariance;
  return anchor;
}

absl::StatusOr<StoredLinkPoint> FromProto(const SiteId& site, const v1::LinkPoint& in) {
  StoredLinkPoint out;
  out.site = site;
  LinkPoint& point = out.point;
  if (!v1::LinkPoint::Kind_IsValid(in.kind())) return Unknown("link_point.kind", in.kind());
  if (!v1::LinkPoint::State_IsValid(in.state())) return Unknown("link_point.state", in.state());
  if (!v1::Map::Environment_IsValid(in.environment())) return Unknown("link_point.environment", in.environment());
  if (in.kind() != 0) point.kind = static_cast<LinkPointKind>(in.kind());
  if (in.state() != 0) point.state = static_cast<PassageState>(in.state());
  if (in.environment() != 0) out.environment = static_cast<Environment>(in.environment());
  ENFILADE_RETURN_IF_ERROR(CheckTag(in.tag()));
  point.tag = in.tag();
  if (in.difficulty() < 0) return InvalidArgument("link_point.difficulty is {}: expected 0 or more", in.difficulty());
  point.difficulty = in.difficulty();
  for (int i = 0; i < in.anchors_size(); ++i) {
    ENFILADE_ASSIGN_OR_RETURN(Anchor anchor, FromProto(fmt::format("link_point.anchors[{}]", i), site, in.anchors(i)));
    point.anchors.push_back(std::move(anchor));
  }
  if (!in.direction_map().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(point.direction, MapOfSite("link_point.direction_map", site, in.direction_map()));
  }
  if (in.has_state_valid_until()) {
    ENFILADE_ASSIGN_OR_RETURN(point.state_valid_until, FromTimestamp(in.state_valid_until()));
  }
  return out;
}

absl::StatusOr<Evidence> FromProto(const LinkPointName& name, const v1::Evidence& in) {
  Evidence out;
  out.link_point = name.link_point;
  ENFILADE_ASSIGN_OR_RETURN(out.map, MapOfSite("evidence.map", name.site, in.map()));
  // A record's image or cloud, under the same rules.
  v1::Record record;
  record.set_sequence(1);
  if (in.has_image()) *record.mutable_image() = in.image();
  if (in.has_cloud()) *record.mutable_point_cloud() = in.cloud();
  if (!in.has_image() && !in.has_cloud()) return InvalidArgument("evidence has no content: expected image or cloud");
  ENFILADE_ASSIGN_OR_RETURN(const Record read, enfilade::FromProto(record));
  out.time = TimeOf(read);
  out.content = *FindBlob(read);
  if (const auto* image = std::get_if<Image>(&read.payload)) {
    out.kind = image->camera == Camera::kRear ? EvidenceKind::kRearImage : EvidenceKind::kFrontImage;
    out.encoding = static_cast<std::int16_t>(image->encoding);
  } else {
    out.kind = EvidenceKind::kCloud;
    out.encoding = static_cast<std::int16_t>(std::get<PointCloud>(read.payload).encoding);
  }
  return out;
}

absl::StatusOr<std::optional<bool>> CandidatesOf(v1::LinkPointSubset subset) {
  if (!v1::LinkPointSubset_IsValid(subset)) return Unknown("subset", subset);
  if (subset == v1::LINK_POINT_SUBSET_UNSPECIFIED) return std::optional<bool>();
  return std::optional<bool>(subset == v1::LINK_POINT_SUBSET_CANDIDATES);
}

absl::StatusOr<std::vector<v1::LinkPoint>> WithEvidence(const Services& services, const CallContext& context,
                                                        const SiteId& site,
                                                        const std::vector<StoredLinkPoint>& link_points) {
  std::vector<LinkPointId> ids;
  std::map<LinkPointId, std::size_t> places;
  std::vector<v1::LinkPoint> out;
  for (const StoredLinkPoint& link_point : link_points) {
    places[link_point.point.id] = out.size();
    ids.push_back(link_point.point.id);
    out.push_back(ToProto(link_point));
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto evidence, services.link_points.ListEvidence(context, site, ids));
  for (const Evidence& item : evidence) *out[places.at(item.link_point)].add_evidence() = ToProto(site, item);
  return out;
}

absl::StatusOr<v1::LinkPoint> WithEvidence(const Services& services, const CallContext& context,
                                           const StoredLinkPoint& link_point) {
  ENFILADE_ASSIGN_OR_RETURN(std::vector<v1::LinkPoint> out,
                            WithEvidence(services, context, link_point.site, {link_point}));
  return std::move(out.front());
}

}  // namespace enfilade::server
