// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/resources.h"

#include <algorithm>
#include <charconv>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kMaxNameCharacters = 200;
constexpr std::size_t kMaxRequestIdBytes = 128;

// The number of code points of UTF-8, which protobuf has checked; npos if `text` contains a NUL.
std::size_t CountCharacters(const std::string& text) {
  if (text.find('\0') != std::string::npos) return std::string::npos;
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

absl::StatusOr<std::chrono::seconds> ReadRetention(const char* field, const google::protobuf::Duration& in) {
  if (in.seconds() < 0 || in.seconds() > storage::kMaxRetention.count() || in.nanos() != 0) {
    return InvalidArgument("{} must be a whole number of seconds, 0 to {}; unset for ever", field,
                           storage::kMaxRetention.count());
  }
  return std::chrono::seconds(in.seconds());
}

absl::StatusOr<storage::RevisionRetention> ReadRevisionRetention(const v1::RevisionRetention& in) {
  constexpr int kMaxNewest = 1'000'000;
  if (in.newest() < 1 || in.newest() > kMaxNewest) {
    return InvalidArgument("site.revision_retention.newest is {}: expected 1 to {}", in.newest(), kMaxNewest);
  }
  storage::RevisionRetention retention{.newest = in.newest()};
  if (in.has_age()) {
    ENFILADE_ASSIGN_OR_RETURN(retention.age, ReadRetention("site.revision_retention.age", in.age()));
  }
  return retention;
}

}  // namespace

absl::Status CheckDisplayName(const char* field, const std::string& name) {
  const std::size_t characters = CountCharacters(name);
  if (characters >= 1 && characters <= kMaxNameCharacters) return absl::OkStatus();
  return InvalidArgument("{} must have 1 to {} characters and no NUL", field, kMaxNameCharacters);
}

v1::Site ToProto(const storage::Site& site) {
  v1::Site out;
  out.set_name(NameOf(site.id));
  out.set_display_name(site.display_name);
  if (site.raw_retention) out.mutable_raw_retention()->set_seconds(site.raw_retention->count());
  if (site.session_retention) out.mutable_session_retention()->set_seconds(site.session_retention->count());
  if (site.revision_retention) {
    out.mutable_revision_retention()->set_newest(site.revision_retention->newest);
    const auto age = site.revision_retention->age;
    if (age) out.mutable_revision_retention()->mutable_age()->set_seconds(age->count());
  }
  if (site.history_retention) out.mutable_history_retention()->set_seconds(site.history_retention->count());
  if (site.audit_retention) out.mutable_audit_retention()->set_seconds(site.audit_retention->count());
  out.set_etag(std::to_string(site.etag));
  *out.mutable_create_time() = convert::ToTimestamp(site.create_time);
  if (site.deletion) {
    *out.mutable_deletion()->mutable_start_time() = convert::ToTimestamp(site.deletion->time);
    out.mutable_deletion()->set_actor(site.deletion->actor);
    out.mutable_deletion()->set_deleted_rows(site.deletion->deleted_rows);
  }
  return out;
}

v1::Robot ToProto(const storage::Robot& robot) {
  v1::Robot out;
  out.set_name(convert::NameOf(convert::RobotName{robot.site, robot.id}));
  out.set_display_name(robot.display_name);
  *out.mutable_create_time() = convert::ToTimestamp(robot.create_time);
  return out;
}

v1::Map ToProto(const storage::Map& map) {
  v1::Map out;
  out.set_name(convert::NameOf(convert::MapName{map.site, map.id}));
  out.set_display_name(map.display_name);
  out.set_level(map.level);
  out.set_environment(map.environment == Environment::kOutdoor ? v1::Map::ENVIRONMENT_OUTDOOR
                                                               : v1::Map::ENVIRONMENT_INDOOR);
  out.set_slam_profile(map.slam_profile);
  for (const Eigen::Vector2d& corner : map.outline) {
    v1::Point& added = *out.mutable_outline()->add_corners();
    added.set_x(corner.x());
    added.set_y(corner.y());
  }
  out.set_pinned(map.pinned);
  if (map.current_revision > 0)
    out.set_latest_revision(convert::NameOf(convert::RevisionName{map.site, map.id, map.current_revision}));
  out.set_etag(std::to_string(map.etag));
  *out.mutable_create_time() = convert::ToTimestamp(map.create_time);
  return out;
}

v1::MapRevision ToProto(const storage::MapRevision& revision) {
  v1::MapRevision out;
  out.set_name(convert::NameOf(convert::RevisionName{revision.site, revision.map, revision.number}));
  static_assert(static_cast<int>(storage::RevisionSource::kRestored) == v1::MapRevision::SOURCE_RESTORED);

  static_assert(static_cast<int>(storage::RevisionSource::kEdit) == v1::MapRevision::SOURCE_EDIT);
  out.set_source(static_cast<v1::MapRevision::Source>(revision.source));
  if (revision.session) out.set_session(convert::NameOf(convert::SessionName{revision.site, *revision.session}));
  out.set_resolution_m(revision.geometry.resolution);
  *out.mutable_pose_map_grid() = enfilade::convert::ToProto(revision.geometry.T_map_grid);
  out.set_width(revision.geometry.width);
  out.set_height(revision.geometry.height);
  out.set_content_sha256(revision.content_sha256);
  *out.mutable_create_time() = convert::ToTimestamp(revision.create_time);
  out.set_tag(revision.tag);
  out.set_edit_version(revision.edit_version);
  for (const MapAliasId& alias : revision.aliases) out.add_aliases(alias.value());
  return out;
}

v1::Session ToProto(const storage::Session& session) {
  v1::Session out;
  out.set_name(convert::NameOf(convert::SessionName{session.site, session.id}));
  out.set_robot(convert::NameOf(convert::RobotName{session.site, session.robot}));
  if (session.map) out.set_map(convert::NameOf(convert::MapName{session.site, *session.map}));
  static_assert(static_cast<int>(storage::SessionState::kFailed) == v1::Session::STATE_FAILED);
  out.set_state(static_cast<v1::Session::State>(session.state));
  out.set_acknowledged_sequence(session.acknowledged_sequence);
  out.set_mapped_sequence(session.mapped_sequence);
  v1::RecordCounts& records = *out.mutable_record_counts();
  records.set_laser_scans(session.record_counts.laser_scans);
  records.set_odometries(session.record_counts.odometry);
  records.set_images(session.record_counts.images);
  records.set_point_clouds(session.record_counts.point_clouds);
  records.set_withheld(session.record_counts.withheld);
  records.set_door_reports(session.record_counts.door_reports);
  v1::MappingCounts& mapping = *out.mutable_mapping_counts();
  mapping.set_paired(session.mapping_counts.paired);
  mapping.set_unpaired(session.mapping_counts.unpaired);
  mapping.set_time_reversed(session.mapping_counts.time_reversed);
  mapping.set_used(session.mapping_counts.used);
  mapping.set_keyframes(session.mapping_counts.keyframes);
  mapping.set_lost(session.mapping_counts.lost);
  out.set_error(session.error);
  *out.mutable_create_time() = convert::ToTimestamp(session.create_time);
  out.set_surveyed(session.surveyed);
  if (session.finish_time) *out.mutable_finish_time() = convert::ToTimestamp(*session.finish_time);
  const sensor::SessionEntry& entry = session.entry;
  if (entry.previous) {
    out.mutable_entry()->set_previous_session(convert::NameOf(convert::SessionName{session.site, *entry.previous}));
  }
  if (entry.T_map_robot)
    *out.mutable_entry()->mutable_pose_map_robot() = enfilade::convert::ToProto(*entry.T_map_robot);
  if (entry.T_odom_robot)
    *out.mutable_entry()->mutable_pose_odom_robot() = enfilade::convert::ToProto(*entry.T_odom_robot);
  return out;
}

v1::Closure ToProto(const convert::SessionName& session, const slam::LoopClosure& closure) {
  v1::Closure out;
  out.set_name(convert::NameOf(convert::LoopClosureName{session.site, session.session, closure.id}));
  out.set_submap(closure.submap);
  out.set_node(closure.node);
  *out.mutable_pose_submap_node() = enfilade::convert::ToProto(closure.T_submap_node);
  static_assert(static_cast<int>(slam::LoopClosureState::kSuspended) == v1::Closure::STATE_SUSPENDED);
  out.set_state(static_cast<v1::Closure::State>(closure.state));
  out.set_score(closure.score);
  out.set_chi2(closure.chi2);
  out.set_reason(closure.reason);
  return out;
}

absl::StatusOr<storage::Site> FromProto(const v1::Site& in) {
  storage::Site site;
  ENFILADE_RETURN_IF_ERROR(CheckDisplayName("site.display_name", in.display_name()));
  site.display_name = in.display_name();
  if (in.has_raw_retention()) {
    ENFILADE_ASSIGN_OR_RETURN(site.raw_retention, ReadRetention("site.raw_retention", in.raw_retention()));
  }
  if (in.has_session_retention()) {
    ENFILADE_ASSIGN_OR_RETURN(site.session_retention, ReadRetention("site.session_retention", in.session_retention()));
  }
  if (in.has_revision_retention()) {
    ENFILADE_ASSIGN_OR_RETURN(site.revision_retention, ReadRevisionRetention(in.revision_retention()));
  }
  if (in.has_history_retention()) {
    ENFILADE_ASSIGN_OR_RETURN(site.history_retention, ReadRetention("site.history_retention", in.history_retention()));
  }
  if (in.has_audit_retention()) {
    ENFILADE_ASSIGN_OR_RETURN(site.audit_retention, ReadRetention("site.audit_retention", in.audit_retention()));
  }
  return site;
}

absl::Status CheckTag(const char* field, const std::string& tag) {
  constexpr std::size_t kMaxTagCharacters = 64;
  if (CountCharacters(tag) <= kMaxTagCharacters) return absl::OkStatus();
  return InvalidArgument("{} must have at most {} characters and no NUL", field, kMaxTagCharacters);
}

absl::StatusOr<storage::Robot> FromProto(const v1::Robot& in) {
  storage::Robot robot;
  ENFILADE_RETURN_IF_ERROR(CheckDisplayName("robot.display_name", in.display_name()));
  robot.display_name = in.display_name();
  return robot;
}

absl::StatusOr<storage::Map> FromProto(const v1::Map& in) {
  storage::Map map;
  ENFILADE_RETURN_IF_ERROR(CheckDisplayName("map.display_name", in.display_name()));
  if (!v1::Map::Environment_IsValid(in.environment())) {
    return InvalidArgument("map.environment is {}: unknown to this server", static_cast<int>(in.environment()));
  }
  map.display_name = in.display_name();
  map.level = in.level();
  map.environment = in.environment() == v1::Map::ENVIRONMENT_OUTDOOR ? Environment::kOutdoor : Environment::kIndoor;
  map.slam_profile = in.slam_profile();
  map.pinned = in.pinned();
  for (const v1::Point& corner : in.outline().corners()) map.outline.emplace_back(corner.x(), corner.y());
  return map;
}

absl::StatusOr<std::int64_t> ParseEtag(const std::string& etag) {
  std::int64_t value = 0;
  if (etag.empty()) return value;
  const auto parsed = std::from_chars(etag.data(), etag.data() + etag.size(), value);
  if (parsed.ec != std::errc() || parsed.ptr != etag.data() + etag.size() || value < 1) {
    return InvalidArgument("etag \"{}\" is not from this server", Excerpt(etag, 100));
  }
  return value;
}

absl::StatusOr<std::string> IdOrNew(const char* field, const std::string& requested) {
  if (requested.empty()) return NewUuid();
  if (IsValidResourceId(requested)) return requested;
  return InvalidArgument("{} is \"{}\": expected 1 to 63 of a-z, 0-9 and \"-\", not \"-\" first or last", field,
                         Excerpt(requested, 100));
}

absl::StatusOr<storage::RequestId> MakeRequestId(const std::string& id, const std::string& request) {
  if (id.size() <= kMaxRequestIdBytes && id.find('\0') == std::string::npos)
    return storage::RequestId(id, Sha256(request));
  return InvalidArgument("request_id has {} bytes: expected a UUID, or another text of at most {} bytes without NUL",
                         id.size(), kMaxRequestIdBytes);
}

std::string IdOfRequest(const std::string& request_id) {
  std::string id = "r";
  for (const char c : Sha256(request_id).substr(0, 16)) id += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return id;
}

absl::Status CheckMask(const google::protobuf::FieldMask& mask, std::initializer_list<const char*> editable) {
  for (const std::string& path : mask.paths()) {
    if (std::find(editable.begin(), editable.end(), path) == editable.end()) {
      return InvalidArgument("update_mask names \"{}\": only {} can be updated", path, fmt::join(editable, ", "));
    }
  }
  return absl::OkStatus();
}

bool IsUpdated(const google::protobuf::FieldMask& mask, const char* path, bool is_set) {
  if (mask.paths().empty()) return is_set;
  return std::find(mask.paths().begin(), mask.paths().end(), path) != mask.paths().end();
}

}  // namespace enfilade::server
