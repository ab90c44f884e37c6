// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/edit/edit_file.h"

#include <algorithm>
#include <map>
#include <optional>

#include "client/cli/commands/edit/edit_points.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/edit/integers.h"
#include "core/options/strict_mapping.h"
#include "fmt/format.h"

namespace enfilade::cli {
namespace {

using edit::LatticePoint;
using edit::Shape;
using yaml_options::StrictMapping;

// Of a fill without bounds: every cell that a map can have.
constexpr edit::CellBox kWholeLattice{-(1 << 21), -(1 << 21), 1 << 22, 1 << 22};

constexpr auto kValues = {std::pair{"unknown", v1::MapEdit::VALUE_UNKNOWN}, std::pair{"free", v1::MapEdit::VALUE_FREE},
                          std::pair{"occupied", v1::MapEdit::VALUE_OCCUPIED},
                          std::pair{"clear", v1::MapEdit::VALUE_CLEAR}};

void FillBox(const edit::CellBox& box, v1::CellBox& out) {
  out.set_first_column(box.first_column);
  out.set_first_row(box.first_row);
  out.set_width(box.width);
  out.set_height(box.height);
}

template <typename Message>
void FillPoints(const std::vector<LatticePoint>& points, Message& out) {
  for (const LatticePoint& point : points) {
    v1::LatticePoint& added = *out.add_points();
    added.set_x(point.x);
    added.set_y(point.y);
  }
}

void FillShape(const edit::Brush& brush, v1::MapEdit& out) {
  FillPoints(brush.points, *out.mutable_brush());
  out.mutable_brush()->set_radius(brush.radius);
}
void FillShape(const edit::Line& line, v1::MapEdit& out) { FillPoints(line.points, *out.mutable_line()); }
void FillShape(const edit::Polygon& polygon, v1::MapEdit& out) {
  for (const auto& ring : polygon.rings) FillPoints(ring, *out.mutable_polygon()->add_rings());
}
void FillShape(const edit::Patch& patch, v1::MapEdit& out) {
  FillBox(patch.box, *out.mutable_patch()->mutable_box());
  out.mutable_patch()->mutable_runs()->Assign(patch.runs.begin(), patch.runs.end());
}

// Rows of "#" and ".", the top one first, as runs from the lower left.
edit::Patch ReadPatch(StrictMapping& of, const EditPoints& points, const YAML::Node& value) {
  std::vector<std::string> rows;
  for (const YAML::Node& row : value) rows.push_back(row.IsScalar() ? row.Scalar() : "");
  const bool is_picture =
      !rows.empty() && !rows[0].empty() && std::all_of(rows.begin(), rows.end(), [&](const std::string& row) {
        return row.size() == rows[0].size() && row.find_first_not_of("#.") == std::string::npos;
      });
  if (!is_picture) {
    of.Fail(value, of.what() + ".patch: expected rows of the same length of \"#\" (taken) and \".\" (left out)");
    return {};
  }
  const LatticePoint corner = points.One(of, "at", of.Find("at"));
  edit::Patch patch{BoxAround({corner}), {0}};
  patch.box.width = static_cast<int>(rows[0].size());
  patch.box.height = static_cast<int>(rows.size());
  bool takes = false;
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    for (const char cell : *row) {
      if ((cell == '#') != takes) {
        patch.runs.push_back(0);
        takes = !takes;
      }
      ++patch.runs.back();
    }
  }
  return patch;
}

edit::Polygon ReadPolygon(StrictMapping& of, const EditPoints& points, const YAML::Node& value) {
  edit::Polygon polygon{{points.Many(of, "polygon", value)}};
  of.Each("holes", [&](const YAML::Node& hole) { polygon.rings.push_back(points.Many(of, "holes", hole)); });
  return polygon;
}

void ReadFill(StrictMapping& of, const EditPoints& points, const YAML::Node& value, v1::MapEdit& out) {
  const LatticePoint seed = points.One(of, "fill", value);
  out.mutable_fill()->mutable_seed()->set_x(seed.x);
  out.mutable_fill()->mutable_seed()->set_y(seed.y);
  const YAML::Node bounds = of.Find("bounds");
  FillBox(bounds.IsDefined() ? BoxAround(points.Rectangle(of, "bounds", bounds)) : kWholeLattice,
          *out.mutable_fill()->mutable_bounds());
}

// The shape under one of its keys; unset: a fill, which is in `out`.
std::optional<Shape> ReadShape(StrictMapping& of, const EditPoints& points, const std::string& kind, v1::MapEdit& out) {
  const YAML::Node value = of.Find(kind);
  if (kind == "brush") return edit::Brush{points.Many(of, kind, value), points.Length(of, "radius")};
  if (kind == "line") return edit::Line{points.Many(of, kind, value)};
  if (kind == "polygon") return ReadPolygon(of, points, value);
  if (kind == "rectangle") return edit::Polygon{{points.Rectangle(of, kind, value)}};
  if (kind == "patch") return ReadPatch(of, points, value);
  ReadFill(of, points, value, out);
  return std::nullopt;
}

void ReadMeaning(StrictMapping& of, v1::MapEdit& out) {
  out.set_value(of.Choice("value", kValues, v1::MapEdit::VALUE_UNSPECIFIED));
  if (out.value() == v1::MapEdit::VALUE_UNSPECIFIED) of.Required<std::string>("value");
  out.set_invisible(of.Get<bool>("invisible", false));
  of.Each("only_where", [&](const YAML::Node& shown) {
    const std::string word = shown.IsScalar() ? shown.Scalar() : "";
    const auto found = std::find_if(kValues.begin(), kValues.end(), [&](const auto& value) {
      return word == value.first && value.second != v1::MapEdit::VALUE_CLEAR;
    });
    if (found == kValues.end()) {
      return of.Fail(shown,
                     fmt::format("{}.only_where has \"{}\": expected unknown, free or occupied", of.what(), word));
    }
    out.add_only_where(found->second);
  });
}

v1::MapEdit ReadEdit(const YAML::Node& node, const std::string& what, const EditPoints& points, absl::Status& status) {
  v1::MapEdit out;
  StrictMapping of(node, what, status);
  std::vector<std::string> kinds;
  for (const char* const kind : {"brush", "line", "polygon", "rectangle", "fill", "patch"}) {
    if (of.Has(kind)) kinds.emplace_back(kind);
  }
  if (kinds.size() != 1) {
    of.Fail(node, what + ": expected one of brush, line, polygon, rectangle, fill and patch");
    return out;
  }
  const std::optional<Shape> shape = ReadShape(of, points, kinds[0], out);
  ReadMeaning(of, out);
  of.Finish();
  if (!status.ok() || !shape) return out;
  const absl::Status valid = edit::Validate(*shape);
  if (!valid.ok()) of.Fail(node, fmt::format("{}: {}", what, std::string(valid.message())));
  std::visit([&](const auto& kind) { FillShape(kind, out); }, *shape);
  return out;
}

// A UUID of version 8 (RFC 9562), whose content is anybody's.
std::string UuidOf(std::string_view content) {
  std::string bytes = Sha256(content).substr(0, 16);
  bytes[6] = static_cast<char>((bytes[6] & 0x0F) | 0x80);
  bytes[8] = static_cast<char>((bytes[8] & 0x3F) | 0x80);
  const std::string hex = ToHex(bytes);
  return fmt::format("{}-{}-{}-{}-{}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4), hex.substr(16, 4),
                     hex.substr(20));
}

}  // namespace

absl::StatusOr<std::vector<v1::MapEdit>> ReadEdits(std::string_view yaml, const edit::Lattice& lattice) {
  using Result = absl::StatusOr<std::vector<v1::MapEdit>>;
  return yaml_options::ReadYaml(yaml, "", [&](const YAML::Node& root) -> Result {
    absl::Status status;
    std::vector<v1::MapEdit> edits;
    StrictMapping file(root, "the file", status);
    const bool in_cells = file.Choice("unit", {std::pair{"m", false}, std::pair{"cells", true}}, false);
    const auto author = file.Get<std::string>("author", "");
    const EditPoints points(lattice, in_cells);
    file.Each("edits", [&](const YAML::Node& node) {
      if (!status.ok()) return;
      edits.push_back(ReadEdit(node, fmt::format("edits[{}]", edits.size()), points, status));
      edits.back().set_author(author);
    });
    file.Finish();
    if (edits.empty()) file.Fail(root, "the file has no edits");
    if (!status.ok()) return status;
    return edits;
  });
}

void GiveIds(const std::string& draft, std::vector<v1::MapEdit>& edits) {
  std::map<std::string, int> seen;
  for (v1::MapEdit& edit : edits) {
    edit.clear_edit_id();
    const std::string content = edit.SerializeAsString();
    edit.set_edit_id(UuidOf(fmt::format("{}\n{}\n{}", draft, seen[content]++, content)));
  }
}

}  // namespace enfilade::cli
