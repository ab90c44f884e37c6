// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/editing/audited_link_point.h"

#include <cmath>
#include <string_view>

#include "absl/time/time.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"
#include "google/protobuf/struct.pb.h"
#include "google/protobuf/util/json_util.h"

namespace enfilade::client {
namespace {

constexpr double kSame = 1e-9;

absl::StatusOr<google::protobuf::Struct> ParseRow(const std::string& row) {
  google::protobuf::Struct parsed;
  if (!google::protobuf::util::JsonStringToMessage(row, &parsed).ok()) {
    return DataLoss("the audit trail has a row that is no JSON object: {}", row.substr(0, 100));
  }
  return parsed;
}

class RowReader {
 public:
  explicit RowReader(const google::protobuf::Struct& row) : row_(row) {}

  // 0, "" and false for a column that is missing or null.
  double Number(const char* column) const { return Find(column).number_value(); }
  int Integer(const char* column) const { return static_cast<int>(std::lround(Number(column))); }
  std::string Text(const char* column) const { return Find(column).string_value(); }
  bool Flag(const char* column) const { return Find(column).bool_value(); }
  const google::protobuf::Value& Find(const char* column) const {
    const auto found = row_.fields().find(column);
    return found == row_.fields().end() ? google::protobuf::Value::default_instance() : found->second;
  }

 private:
  const google::protobuf::Struct& row_;
};

std::string NameIn(const std::string& site, const char* collection, const std::string& id) {
  return id.empty() ? "" : fmt::format("sites/{}/{}/{}", site, collection, id);
}

}  // namespace

AuditedPart PartOf(const v1::AuditEntry& entry) {
  // sites/SITE/linkPoints/ID[/anchors/MAP | /evidence/MAP/KIND]
  std::vector<std::string> segments;
  std::string_view rest = entry.resource();
  while (!rest.empty()) {
    const std::size_t end = rest.find('/');
    segments.emplace_back(rest.substr(0, end));
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  AuditedPart part;
  if (segments.size() < 4 || segments[0] != "sites" || segments[2] != "linkPoints") return part;
  part.link_point = NameIn(segments[1], "linkPoints", segments[3]);
  if (segments.size() == 6 && segments[4] == "anchors") part.anchor_map = NameIn(segments[1], "maps", segments[5]);
  part.evidence = segments.size() > 4 && segments[4] == "evidence";
  return part;
}

absl::StatusOr<v1::LinkPoint> LinkPointOfRow(const std::string& text) {
  ENFILADE_ASSIGN_OR_RETURN(const google::protobuf::Struct parsed, ParseRow(text));
  const RowReader row(parsed);
  v1::LinkPoint link_point;
  const std::string site = row.Text("site_id");
  link_point.set_name(NameIn(site, "linkPoints", row.Text("link_point_id")));
  // The database's numbers are the API's.
  link_point.set_kind(static_cast<v1::LinkPoint::Kind>(row.Integer("kind")));
  link_point.set_tag(row.Text("tag"));
  link_point.set_direction_map(NameIn(site, "maps", row.Text("direction_map_id")));
  link_point.set_difficulty(row.Integer("difficulty"));
  link_point.set_environment(static_cast<v1::Map::Environment>(row.Integer("environment")));
  link_point.set_state(static_cast<v1::LinkPoint::State>(row.Integer("state")));
  link_point.set_use(static_cast<v1::LinkPoint::Use>(row.Integer("use")));
  link_point.set_forced(row.Flag("forced"));
  if (row.Find("pinned").has_bool_value()) link_point.set_pinned(row.Flag("pinned"));  // older rows lack it
  const std::string until = row.Text("valid_until");
  if (until.empty()) return link_point;
  absl::Time time;
  std::string error;
  if (!absl::ParseTime(absl::RFC3339_full, until, &time, &error)) {
    return DataLoss("the audit trail has a time that is none: {}", until);
  }
  link_point.mutable_state_valid_until()->set_seconds(absl::ToUnixSeconds(time));
  link_point.mutable_state_valid_until()->set_nanos(
      static_cast<int>(absl::ToInt64Nanoseconds(time - absl::FromUnixSeconds(absl::ToUnixSeconds(time)))));
  return link_point;
}

absl::StatusOr<AuditedAnchor> AnchorOfRow(const std::string& text) {
  ENFILADE_ASSIGN_OR_RETURN(const google::protobuf::Struct parsed, ParseRow(text));
  const RowReader row(parsed);
  AuditedAnchor audited;
  audited.ordinal = row.Integer("ordinal");
  audited.anchor.set_map(NameIn(row.Text("site_id"), "maps", row.Text("map_id")));
  v1::PoseWithCovariance& place = *audited.anchor.mutable_pose_map_place();
  place.mutable_pose()->set_x(row.Number("x"));
  place.mutable_pose()->set_y(row.Number("y"));
  place.mutable_pose()->set_yaw(row.Number("yaw"));
  const google::protobuf::Value& covariance = row.Find("covariance");
  for (const google::protobuf::Value& value : covariance.list_value().values()) {
    place.add_covariance(value.number_value());
  }
  return audited;
}

bool IsSame(const v1::Anchor& a, const v1::Anchor& b) {
  const v1::PoseWithCovariance& x = a.pose_map_place();
  const v1::PoseWithCovariance& y = b.pose_map_place();
  if (a.map() != b.map() || x.covariance_size() != y.covariance_size()) return false;
  for (int i = 0; i < x.covariance_size(); ++i) {
    if (std::abs(x.covariance(i) - y.covariance(i)) > kSame) return false;
  }
  return std::abs(x.pose().x() - y.pose().x()) <= kSame && std::abs(x.pose().y() - y.pose().y()) <= kSame &&
         std::abs(WrapAngle(x.pose().yaw() - y.pose().yaw())) <= kSame;
}

}  // namespace enfilade::client
