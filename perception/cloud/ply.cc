// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "perception/cloud/decode_cloud.h"
#include "perception/cloud/point_fields.h"

namespace enfilade::perception {
namespace {

struct PlyHeader {
  bool is_ascii = false;
  std::vector<PointField> fields;  // of the vertices
  std::size_t points = 0;
};

absl::StatusOr<PointField> FieldOf(std::string_view type, std::string_view name) {
  using Kind = PointField::Kind;
  struct Type {
    std::string_view name;
    Kind kind;
    std::size_t size;
  };
  static constexpr Type kTypes[] = {
      {"char", Kind::kSigned, 1},     {"int8", Kind::kSigned, 1},     {"uchar", Kind::kUnsigned, 1},
      {"uint8", Kind::kUnsigned, 1},  {"short", Kind::kSigned, 2},    {"int16", Kind::kSigned, 2},
      {"ushort", Kind::kUnsigned, 2}, {"uint16", Kind::kUnsigned, 2}, {"int", Kind::kSigned, 4},
      {"int32", Kind::kSigned, 4},    {"uint", Kind::kUnsigned, 4},   {"uint32", Kind::kUnsigned, 4},
      {"float", Kind::kFloat, 4},     {"float32", Kind::kFloat, 4},   {"double", Kind::kFloat, 8},
      {"float64", Kind::kFloat, 8}};
  for (const Type& known : kTypes) {
    if (known.name == type) return PointField{std::string(name), known.kind, known.size, 1};
  }
  return InvalidArgument("PLY: a vertex has the property {} of type {}: expected a number", name, type);
}

// Reads the header and removes it from `bytes`. Elements after the vertices are ignored; elements before them are
// refused, because they would have to be read.
absl::StatusOr<PlyHeader> ReadPlyHeader(std::string_view& bytes) {
  PlyHeader header;
  bool has_format = false;
  bool has_vertices = false;
  bool in_vertices = false;
  for (;;) {
    const std::optional<std::string_view> line = TakeLine(bytes);
    if (!line) return InvalidArgument("PLY: the header has no end");
    const std::vector<std::string_view> words = Words(*line);
    if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() >= 2) {
      if (words[1] != "ascii" && words[1] != "binary_little_endian") {
        return InvalidArgument("PLY: format {}: expected ascii or binary_little_endian", words[1]);
      }
      header.is_ascii = words[1] == "ascii";
      has_format = true;
    } else if (words[0] == "element" && words.size() == 3) {
      in_vertices = words[1] == "vertex";
      if (!in_vertices && !has_vertices) return InvalidArgument("PLY: the element {} precedes the vertices", words[1]);
      if (!in_vertices) continue;
      const std::optional<std::size_t> count = ParseCount(words[2]);
      if (!count || *count > kMaxCloudPoints) {
        return InvalidArgument("PLY: {} vertices: expected a number up to {}", words[2], kMaxCloudPoints);
      }
      header.points = *count;
      has_vertices = true;
    } else if (words[0] == "property" && words.size() >= 3) {
      if (!in_vertices) continue;
      ENFILADE_ASSIGN_OR_RETURN(PointField field, FieldOf(words[1], words[2]));
      header.fields.push_back(std::move(field));
    } else {
      return InvalidArgument("PLY: unknown header line \"{}\"", *line);
    }
  }
  if (!has_format || !has_vertices)
    return InvalidArgument("PLY: the header has no {}", has_format ? "vertices" : "format");
  return header;
}

}  // namespace

absl::StatusOr<Cloud> DecodePly(std::string_view bytes) {
  ENFILADE_ASSIGN_OR_RETURN(const PlyHeader header, ReadPlyHeader(bytes));
  ENFILADE_ASSIGN_OR_RETURN(const auto xyz, FindXyz(header.fields));
  if (header.is_ascii) return ReadText(bytes, header.points, header.fields, xyz);
  const std::size_t expected = header.points * PointSize(header.fields);
  if (bytes.size() < expected) return InvalidArgument("PLY: truncated: {} of {} bytes", bytes.size(), expected);
  return ReadRows(bytes, header.points, header.fields, xyz);
}

}  // namespace enfilade::perception
