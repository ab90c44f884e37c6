// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/edit/convert.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "google/protobuf/util/time_util.h"
#include "proto/convert/record.h"

namespace enfilade::server {
namespace {

using edit::Instruction;
using google::protobuf::util::TimeUtil;

constexpr std::size_t kMaxAuthorBytes = 256;  // 64 characters of up to four bytes

std::size_t CharactersIn(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

void PutPoints(const std::vector<edit::LatticePoint>& points,
               google::protobuf::RepeatedPtrField<v1::LatticePoint>& out) {
  for (const edit::LatticePoint& point : points) *out.Add() = ToProto(point);
}
std::vector<edit::LatticePoint> PointsOf(const google::protobuf::RepeatedPtrField<v1::LatticePoint>& points) {
  std::vector<edit::LatticePoint> result;
  for (const v1::LatticePoint& point : points) result.push_back(FromProto(point));
  return result;
}

void PutShape(const edit::Brush& brush, v1::MapEdit& out) {
  PutPoints(brush.points, *out.mutable_brush()->mutable_points());
  out.mutable_brush()->set_radius(brush.radius);
}
void PutShape(const edit::Line& line, v1::MapEdit& out) {
  PutPoints(line.points, *out.mutable_line()->mutable_points());
}
void PutShape(const edit::Polygon& polygon, v1::MapEdit& out) {
  for (const auto& ring : polygon.rings) PutPoints(ring, *out.mutable_polygon()->add_rings()->mutable_points());
}
void PutShape(const edit::Patch& patch, v1::MapEdit& out) {
  *out.mutable_patch()->mutable_box() = ToProto(patch.box);
  out.mutable_patch()->mutable_runs()->Assign(patch.runs.begin(), patch.runs.end());
}

// Of shapes that are drawn as they are.
absl::StatusOr<edit::Shape> ShapeOf(const std::string& field, const v1::MapEdit& edit) {
  switch (edit.shape_case()) {
    case v1::MapEdit::kBrush:
      return edit::Brush{PointsOf(edit.brush().points()), edit.brush().radius()};
    case v1::MapEdit::kLine:
      return edit::Line{PointsOf(edit.line().points())};
    case v1::MapEdit::kPolygon: {
      edit::Polygon polygon;
      for (const v1::LatticeRing& ring : edit.polygon().rings()) polygon.rings.push_back(PointsOf(ring.points()));
      return polygon;
    }
    case v1::MapEdit::kPatch:
      return edit::Patch{FromProto(edit.patch().box()), {edit.patch().runs().begin(), edit.patch().runs().end()}};
    default:
      return InvalidArgument("{} has no shape", field);
  }
}

absl::StatusOr<Instruction> InstructionOf(const std::string& field, v1::MapEdit::Value value) {
  switch (value) {
    case v1::MapEdit::VALUE_UNKNOWN:
      return Instruction::kUnknown;
    case v1::MapEdit::VALUE_FREE:
      return Instruction::kFree;
    case v1::MapEdit::VALUE_OCCUPIED:
      return Instruction::kOccupied;
    case v1::MapEdit::VALUE_CLEAR:
      return Instruction::kClear;
    default:
      return InvalidArgument("{}.value is {}: expected unknown, free, occupied or clear", field,
                             static_cast<int>(value));
  }
}

absl::StatusOr<grid::CellClass> ClassOfValue(const std::string& field, int value) {
  if (value == v1::MapEdit::VALUE_UNKNOWN) return grid::CellClass::kUnknown;
  if (value == v1::MapEdit::VALUE_FREE) return grid::CellClass::kFree;
  if (value == v1::MapEdit::VALUE_OCCUPIED) return grid::CellClass::kOccupied;
  return InvalidArgument("{}.only_where has {}: expected unknown, free or occupied", field, value);
}

absl::Status CheckEditId(const std::string& field, const std::string& id) {
  const bool is_plain = std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
  });
  if (!id.empty() && id.size() <= 63 && is_plain) return absl::OkStatus();
  return InvalidArgument("{}.edit_id is \"{}\": expected a UUID, or 1 to 63 letters, digits and \"-\"", field,
                         Excerpt(id, 100));
}

}  // namespace

v1::CellBox ToProto(const edit::CellBox& box) {
  v1::CellBox out;
  out.set_first_column(box.first_column);
  out.set_first_row(box.first_row);
  out.set_width(box.width);
  out.set_height(box.height);
  return out;
}

edit::CellBox FromProto(const v1::CellBox& box) {
  return {box.first_column(), box.first_row(), box.width(), box.height()};
}

v1::LatticePoint ToProto(const edit::LatticePoint& point) {
  v1::LatticePoint out;
  out.set_x(point.x);
  out.set_y(point.y);
  return out;
}

edit::LatticePoint FromProto(const v1::LatticePoint& point) { return {point.x(), point.y()}; }

v1::MapLattice ToProto(const edit::Lattice& lattice) {
  v1::MapLattice out;
  out.set_resolution_m(lattice.resolution);
  *out.mutable_pose_map_lattice() = convert::ToProto(lattice.T_map_lattice);
  return out;
}

v1::MapChangeCounts ToProto(const ChangeCounts& changes) {
  v1::MapChangeCounts out;
  out.set_to_unknown(changes.to_unknown);
  out.set_to_free(changes.to_free);
  out.set_to_occupied(changes.to_occupied);
  return out;
}

v1::MapEdit::Value ToProto(Instruction instruction) {
  return static_cast<v1::MapEdit::Value>(instruction);  // the same numbers
}

v1::MapEditTile ToProto(const ChangedTile& tile) {
  v1::MapEditTile out;
  out.set_row(tile.index.row);
  out.set_column(tile.index.column);
  out.set_sha256(tile.sha256);
  return out;
}

v1::MapDraft ToProto(const storage::MapDraft& draft) {
  v1::MapDraft out;
  out.set_name(NameOf(draft.key.site, draft.key.map, draft.key.draft));
  out.set_display_name(draft.display_name);
  out.set_author(draft.author);
  out.set_state(draft.published ? v1::MapDraft::STATE_PUBLISHED : v1::MapDraft::STATE_OPEN);
  out.set_base_edit_version(draft.base_edit_version);
  *out.mutable_lattice() = ToProto(draft.lattice);
  out.set_head(draft.head);
  out.set_active_edits(draft.active_edits);
  out.set_etag(std::to_string(draft.etag));
  *out.mutable_create_time() = TimeUtil::NanosecondsToTimestamp(draft.create_time);
  if (draft.published) {
    *out.mutable_publish_time() = TimeUtil::NanosecondsToTimestamp(draft.published->time);
    out.set_edit_version(draft.published->edit_version);
    out.set_revision(convert::NameOf(convert::RevisionName{draft.key.site, draft.key.map, draft.published->revision}));
    out.set_message(draft.published->message);
  }
  return out;
}

v1::MapEdit ToProto(const storage::StoredMapEdit& stored) {
  v1::MapEdit out;
  const edit::KeptEdit& kept = stored.kept;
  out.set_edit_id(kept.id);
  out.set_author(kept.author);
  out.set_value(ToProto(kept.edit.instruction));
  std::visit([&](const auto& shape) { PutShape(shape, out); }, kept.edit.shape);
  out.set_invisible(kept.edit.invisible);
  out.set_sequence(kept.sequence);
  out.set_head(stored.head);
  out.set_active(kept.active);
  *out.mutable_create_time() = TimeUtil::NanosecondsToTimestamp(stored.create_time);
  return out;
}

absl::StatusOr<DrawnEdit> FromProto(const std::string& field, const v1::MapEdit& edit, const std::string& author) {
  DrawnEdit drawn;
  ENFILADE_RETURN_IF_ERROR(CheckEditId(field, edit.edit_id()));
  drawn.id = edit.edit_id();
  drawn.author = edit.author().empty() ? author : edit.author();
  if (CharactersIn(drawn.author) > 64) {
    return InvalidArgument("{}.author has {} characters: at most 64", field, CharactersIn(drawn.author));
  }
  ENFILADE_ASSIGN_OR_RETURN(drawn.edit.instruction, InstructionOf(field, edit.value()));
  drawn.edit.invisible = edit.invisible();
  for (const int value : edit.only_where()) {
    ENFILADE_ASSIGN_OR_RETURN(const grid::CellClass wanted, ClassOfValue(field, value));
    drawn.only_where.push_back(wanted);
  }
  if (edit.has_fill()) {
    constexpr int kEnd = edit::kMaxCoordinate / edit::kUnitsPerCell;
    const edit::CellBox everywhere{-kEnd, -kEnd, 2 * kEnd, 2 * kEnd};
    drawn.fill = DrawnEdit::Fill{FromProto(edit.fill().seed()),
                                 edit.fill().has_bounds() ? FromProto(edit.fill().bounds()) : everywhere};
    return drawn;
  }
  ENFILADE_ASSIGN_OR_RETURN(drawn.edit.shape, ShapeOf(field, edit));
  return drawn;
}

storage::MapDraftKey KeyOf(const convert::MapDraftName& name) { return {name.site, name.map, name.draft}; }

absl::StatusOr<std::string> AuthorOr(const char* field, const std::string& author, const Call& call) {
  if (author.empty()) return call.principal().name.substr(0, kMaxAuthorBytes);
  if (CharactersIn(author) <= 64) return author;
  return InvalidArgument("{} has {} characters: at most 64", field, CharactersIn(author));
}

absl::Status CheckMessage(const char* field, const std::string& message) {
  const std::size_t characters = CharactersIn(message);
  if (characters >= 1 && characters <= 500) return absl::OkStatus();
  return InvalidArgument("{} has {} characters: say in 1 to 500 what was edited and why", field, characters);
}

}  // namespace enfilade::server
