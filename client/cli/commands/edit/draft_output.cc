// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/edit/draft_output.h"

#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "core/base/status_macros.h"
#include "fmt/ranges.h"
#include "proto/convert/record.h"

namespace enfilade::cli {

absl::StatusOr<std::string> FindDraftName(const client::Connection& connection, const Globals& globals,
                                          const std::string& map, const std::string& draft) {
  if (draft.starts_with("sites/")) return draft;
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map found, FindMap(connection, globals, map));
  return found.name() + "/drafts/" + draft;
}

edit::Lattice LatticeOf(const v1::MapLattice& lattice) {
  return {lattice.resolution_m(), convert::FromProto(lattice.pose_map_lattice())};
}

std::string ValueText(v1::MapEdit::Value value) { return EnumText(v1::MapEdit::Value_Name(value), "VALUE_"); }

std::string StateText(const v1::MapDraft& draft) {
  if (draft.state() != v1::MapDraft::STATE_PUBLISHED) return "open";
  return fmt::format("published as {}", draft.edit_version());
}

std::string PlaceText(const v1::CellBox& box, const edit::Lattice& lattice) {
  const Eigen::Vector2d corner =
      lattice.T_map_lattice * (Eigen::Vector2d(box.first_column(), box.first_row()) * lattice.resolution);
  return fmt::format("{:.2f} x {:.2f} m at ({:.2f}, {:.2f})", box.width() * lattice.resolution,
                     box.height() * lattice.resolution, corner.x(), corner.y());
}

std::string ChangesText(const v1::MapChangeCounts& changes) {
  std::vector<std::string> parts;
  for (const auto& [count, word] : {std::pair{changes.to_free(), "free"}, std::pair{changes.to_occupied(), "occupied"},
                                    std::pair{changes.to_unknown(), "unknown"}}) {
    if (count == 0) continue;
    parts.push_back(parts.empty() ? fmt::format("{} cells become {}", count, word) : fmt::format("{} {}", count, word));
  }
  return parts.empty() ? "no cell changes" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string PeopleText(const google::protobuf::RepeatedPtrField<std::string>& people) {
  std::vector<std::string> named;
  for (const std::string& name : people) {
    if (!name.empty()) named.push_back(name);
  }
  return named.empty() ? "nobody named" : fmt::format("{}", fmt::join(named, ", "));
}

nlohmann::json DraftToJson(const v1::MapDraft& draft) {
  const Pose2 origin = convert::FromProto(draft.lattice().pose_map_lattice());
  nlohmann::json json{{"name", draft.name()},
                      {"display_name", draft.display_name()},
                      {"author", draft.author()},
                      {"state", draft.state() == v1::MapDraft::STATE_PUBLISHED ? "published" : "open"},
                      {"base_edit_version", draft.base_edit_version()},
                      {"resolution_m", draft.lattice().resolution_m()},
                      {"origin", {origin.x, origin.y, origin.yaw}},
                      {"head", draft.head()},
                      {"active_edits", draft.active_edits()},
                      {"etag", draft.etag()},
                      {"create_time", FormatTime(draft.create_time())}};
  if (draft.state() == v1::MapDraft::STATE_PUBLISHED) {
    json["edit_version"] = draft.edit_version();
    json["revision"] = draft.revision();
    json["message"] = draft.message();
    json["publish_time"] = FormatTime(draft.publish_time());
  }
  return json;
}

nlohmann::json ChangesToJson(const v1::MapChangeCounts& changes) {
  return {{"to_unknown", changes.to_unknown()}, {"to_free", changes.to_free()}, {"to_occupied", changes.to_occupied()}};
}

nlohmann::json BoxToJson(const v1::CellBox& box) {
  return {{"first_column", box.first_column()},
          {"first_row", box.first_row()},
          {"width", box.width()},
          {"height", box.height()}};
}

}  // namespace enfilade::cli
