// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/read_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/building_plan.h"
#include "core/prior/formats/dxf_plan.h"
#include "core/prior/formats/geojson_plan.h"
#include "core/prior/formats/svg_plan.h"
#include "core/prior/plan/plan_check.h"
#include "core/prior/plan/planar.h"
#include "io/file.h"
#include "perception/plan/pdf_page.h"
#include "perception/plan/plan_picture.h"
#include "perception/plan/walls/wall_doors.h"

namespace enfilade::perception {
namespace {

absl::Status CheckMeasure(const std::optional<PlanMeasure>& measure) {
  if (!measure) return absl::OkStatus();
  const double units = (measure->to - measure->from).norm();
  if (!(units > 0) || !std::isfinite(units) || !(measure->metres > 0) || !std::isfinite(measure->metres)) {
    return InvalidArgument("measure: needs two different points and a positive length, got {} units of {} m", units,
                           measure->metres);
  }
  return absl::OkStatus();
}

enum class PlanKind { kPicture, kPdf, kSvg, kDxf, kGeoJson, kBuilding };

PlanKind KindOf(std::string_view bytes) {
  if (bytes.substr(0, 5) == "%PDF-") return PlanKind::kPdf;
  if (bytes.substr(0, 3) == "\xEF\xBB\xBF") bytes.remove_prefix(3);
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return PlanKind::kPicture;
  const std::string_view begin = bytes.substr(first, 4096);
  if (begin[0] == '{') return PlanKind::kGeoJson;
  if (begin[0] == '<') return PlanKind::kSvg;
  if (begin.substr(0, 18) == "AutoCAD Binary DXF") return PlanKind::kDxf;
  if (begin.substr(0, 3) == "999" || (begin[0] == '0' && begin.find("SECTION") != std::string_view::npos)) {
    return PlanKind::kDxf;
  }
  if (bytes.find("levels:") != std::string_view::npos && begin.find('\0') == std::string_view::npos) {
    return PlanKind::kBuilding;
  }
  return PlanKind::kPicture;
}

void AddRooms(PlanFile& file) {
  const double narrowest = prior::NarrowestRoom(file.graph);
  if (prior::IsCrowded(file.graph, narrowest)) {
    file.warnings.push_back("too many walls lie side by side to look for rooms");
  } else {
    file.graph.rooms = prior::FindRooms(file.graph, narrowest);
  }
}

absl::Status CheckLines(const prior::PlanGraph& lines) {
  if (lines.walls.size() > prior::kMostWalls) return prior::CheckPlan(lines);
  return prior::Validate(lines);
}

// Lines of a drawing become a planar graph with doors where its lines leave gaps.
absl::StatusOr<PlanFile> FromLines(prior::VectorPlan drawing, const std::optional<PlanMeasure>& measure) {
  PlanFile file{std::move(drawing.graph), std::move(drawing.warnings), std::nullopt};
  if (measure) file.graph.metres_per_unit = MetresPerUnit(*measure, file.graph);
  ENFILADE_RETURN_IF_ERROR(CheckLines(file.graph));
  const double diagonal = prior::DiagonalOf(file.graph);
  const double weld = prior::JoinDistance(file.graph);
  if (prior::IsCrowded(file.graph, weld)) {
    return ResourceExhausted("{} lines, of which too many lie within {:g} units of each other: choose layers",
                             file.graph.walls.size(), weld);
  }
  file.graph = prior::Planarise(file.graph, weld);
  if (file.graph.walls.size() > prior::kMostWalls) {
    return ResourceExhausted("the lines cross so often that there are more than {} walls: choose layers",
                             prior::kMostWalls);
  }
  if (file.graph.doors.empty()) file.graph.doors = FindDoors(file.graph, diagonal);
  return file;
}

absl::StatusOr<PlanFile> FromBuilding(std::string_view bytes, const ReadPlanOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const prior::Building building, prior::ParseBuilding(std::string(bytes)));
  std::string names;
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < building.levels.size(); ++i) {
    names += (names.empty() ? "" : ", ") + building.levels[i].name;
    if (building.levels[i].name == options.level || (options.level.empty() && !chosen)) chosen = i;
  }
  if (!chosen) {
    for (const prior::BuildingRemark& remark : building.remarks) {
      if (remark.refused) return InvalidArgument("{}: {}", remark.item, remark.why);
    }
    return InvalidArgument("the building has no level \"{}\"; it has {}", options.level, names);
  }
  ENFILADE_ASSIGN_OR_RETURN(PlanFile file, FromLines({prior::PlanOfLevel(building, *chosen), {}}, std::nullopt));
  for (const prior::BuildingRemark& remark : building.remarks) file.warnings.push_back(remark.item + ": " + remark.why);
  if (building.levels.size() > 1 && options.level.empty()) {
    file.warnings.push_back(fmt::format("level {} of {} was read", building.levels[*chosen].name, names));
  }
  return file;
}

absl::StatusOr<PlanFile> FromPicture(std::string_view bytes, const std::optional<PlanMeasure>& measure) {
  ENFILADE_ASSIGN_OR_RETURN(PicturedPlan pictured, RecognisePlan(bytes, measure));
  PlanFile file{std::move(pictured.graph), {}, std::move(pictured.picture)};
  if (file.graph.H_sheet_photo) {
    file.warnings.push_back(fmt::format(
        "the picture is the photo of a page, which was rectified to {}x{} pixels: walls are in pixels of the "
        "page, points that you give are in pixels of the photo",
        file.picture->width, file.picture->height));
  }
  return file;
}

absl::StatusOr<PlanFile> DecodeAny(std::string_view bytes, const ReadPlanOptions& options) {
  switch (KindOf(bytes)) {
    case PlanKind::kGeoJson: {
      ENFILADE_ASSIGN_OR_RETURN(prior::PlanGraph graph, prior::ReadGeoJsonPlan(bytes));
      if (options.measure) graph.metres_per_unit = MetresPerUnit(*options.measure, graph);
      return PlanFile{std::move(graph), {}, std::nullopt};
    }
    case PlanKind::kSvg: {
      ENFILADE_ASSIGN_OR_RETURN(prior::VectorPlan drawing, prior::ReadSvgPlan(bytes, options.layers));
      return FromLines(std::move(drawing), options.measure);
    }
    case PlanKind::kDxf: {
      ENFILADE_ASSIGN_OR_RETURN(prior::VectorPlan drawing, prior::ReadDxfPlan(bytes, options.layers));
      return FromLines(std::move(drawing), options.measure);
    }
    case PlanKind::kBuilding:
      return FromBuilding(bytes, options);
    case PlanKind::kPdf: {
      ENFILADE_ASSIGN_OR_RETURN(const std::string png, RenderPdfPage(bytes, options.page));
      return FromPicture(png, options.measure);
    }
    case PlanKind::kPicture:
      break;
  }
  return FromPicture(bytes, options.measure);
}

}  // namespace

absl::StatusOr<PlanFile> DecodePlan(std::string_view bytes, const ReadPlanOptions& options) {
  ENFILADE_RETURN_IF_ERROR(CheckMeasure(options.measure));
  ENFILADE_ASSIGN_OR_RETURN(PlanFile file, DecodeAny(bytes, options));
  ENFILADE_RETURN_IF_ERROR(prior::CheckPlan(file.graph));
  if (file.graph.rooms.empty()) AddRooms(file);
  if (!file.graph.metres_per_unit) file.warnings.push_back("the scale is unknown: give a measured distance");
  return file;
}

absl::StatusOr<PlanFile> ReadPlanFile(const std::filesystem::path& path, const ReadPlanOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
  absl::StatusOr<PlanFile> file = DecodePlan(bytes, options);
  if (!file.ok()) return WithContext(file.status(), path.string());
  return file;
}

absl::StatusOr<prior::PlanGraph> ReadPlan(const std::filesystem::path& path, const ReadPlanOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(PlanFile file, ReadPlanFile(path, options));
  return std::move(file.graph);
}

}  // namespace enfilade::perception
