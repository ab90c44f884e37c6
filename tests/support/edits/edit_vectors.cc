// SPDX-License-Identifier: Apache-2.0
#include "tests/support/edits/edit_vectors.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "core/base/error.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

template <typename Message>
std::vector<edit::LatticePoint> PointsIn(const Message& message) {
  std::vector<edit::LatticePoint> points;
  for (const v1::LatticePoint& point : message.points()) points.push_back({point.x(), point.y()});
  return points;
}

edit::Shape ShapeIn(const v1::MapEdit& edit) {
  if (edit.has_brush()) return edit::Brush{PointsIn(edit.brush()), edit.brush().radius()};
  if (edit.has_line()) return edit::Line{PointsIn(edit.line())};
  if (edit.has_patch()) {
    const v1::CellBox& box = edit.patch().box();
    return edit::Patch{{box.first_column(), box.first_row(), box.width(), box.height()},
                       {edit.patch().runs().begin(), edit.patch().runs().end()}};
  }
  edit::Polygon polygon;
  for (const v1::LatticeRing& ring : edit.polygon().rings()) polygon.rings.push_back(PointsIn(ring));
  return polygon;
}

}  // namespace

std::vector<std::filesystem::path> EditVectorFiles() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(ProjectData("edits"))) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

absl::StatusOr<EditVectors> ReadEditVectors(const std::filesystem::path& path) {
  std::ifstream file(path);
  const nlohmann::json document = nlohmann::json::parse(file, nullptr, false);
  if (document.is_discarded()) return InvalidArgument("{} is not JSON", path.string());
  EditVectors vectors;
  for (const nlohmann::json& edit : document.at("edits")) {
    const auto status = google::protobuf::util::JsonStringToMessage(edit.dump(), &vectors.edits.emplace_back());
    if (!status.ok()) return InvalidArgument("{}: {}", path.string(), status.ToString());
  }
  for (const nlohmann::json& tile : document.at("tiles")) {
    vectors.tiles[{tile.at("row"), tile.at("column")}] = {
        absl::HexStringToBytes(tile.at("sha256").get_ref<const std::string&>()), tile.at("cells")};
  }
  return vectors;
}

edit::MapEdit ToCoreEdit(const v1::MapEdit& edit) {
  return {static_cast<edit::Instruction>(edit.value()), ShapeIn(edit), edit.invisible()};
}

}  // namespace enfilade::testing
