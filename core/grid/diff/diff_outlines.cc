// SPDX-License-Identifier: Apache-2.0
#include "core/grid/diff/diff_outlines.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/diff/cell_outlines.h"
#include "core/grid/diff/diff_lattice.h"

namespace enfilade::grid {
namespace {

constexpr std::size_t kMaxCorners = 500'000;

struct Outlined {
  const char* change;
  ChangedGroup group;
  std::vector<ChangedRun> runs;
};

// The largest groups, each with its runs.
std::vector<Outlined> LargestOf(const ChangedRuns& changed, const char* change, std::size_t count) {
  std::vector<Outlined> largest;
  std::unordered_map<std::uint32_t, std::size_t> place;  // by the group's first run
  for (const ChangedGroup& group : changed.Largest(count)) {
    place.emplace(group.first_run, largest.size());
    largest.push_back({change, group, {}});
  }
  for (const ChangedRun& run : changed.runs()) {
    const auto found = place.find(run.group);
    if (found != place.end()) largest[found->second].runs.push_back(run);
  }
  return largest;
}

class OutlineWriter {
 public:
  explicit OutlineWriter(const DiffLattice& lattice) : lattice_(lattice) {}

  absl::Status Add(const Outlined& outlined) {
    const std::vector<CellPolygon> polygons = OutlinesOf(outlined.runs);
    const double cell_m2 = lattice_.resolution * lattice_.resolution;
    text_ += fmt::format(
        "{}{{\"type\":\"Feature\",\"properties\":{{\"change\":\"{}\",\"cells\":{},\"area_m2\":{:.4f}}},"
        "\"geometry\":{{\"type\":\"{}\",\"coordinates\":",
        features_++ == 0 ? "" : ",\n", outlined.change, outlined.group.cells,
        static_cast<double>(outlined.group.cells) * cell_m2, polygons.size() == 1 ? "Polygon" : "MultiPolygon");
    if (polygons.size() > 1) text_ += '[';
    for (std::size_t i = 0; i < polygons.size(); ++i) {
      if (i > 0) text_ += ',';
      AddPolygon(polygons[i]);
    }
    if (polygons.size() > 1) text_ += ']';
    text_ += "}}";
    if (corners_ <= kMaxCorners) return absl::OkStatus();
    return ResourceExhausted(
        "the outlines of what came and went have more than {} corners: ask for fewer regions, or without GeoJSON",
        kMaxCorners);
  }
  std::string Finish() && { return "{\"type\":\"FeatureCollection\",\"features\":[" + text_ + "]}\n"; }

 private:
  void AddPolygon(const CellPolygon& polygon) {
    text_ += '[';
    AddRing(polygon.outer);
    for (const CellRing& hole : polygon.holes) {
      text_ += ',';
      AddRing(hole);
    }
    text_ += ']';
  }
  void AddRing(const CellRing& ring) {
    corners_ += ring.size();
    text_ += '[';
    for (std::size_t i = 0; i <= ring.size(); ++i) {
      const CellIndex corner = ring[i % ring.size()];
      const Eigen::Vector2d p =
          lattice_.T_map_lattice * (Eigen::Vector2d(corner.column, corner.row) * lattice_.resolution);
      text_ += fmt::format("{}[{:.4f},{:.4f}]", i == 0 ? "" : ",", p.x(), p.y());
    }
    text_ += ']';
  }

  const DiffLattice& lattice_;
  std::string text_;
  std::size_t features_ = 0;
  std::size_t corners_ = 0;
};

}  // namespace

absl::StatusOr<std::string> OutlinesToGeoJson(const ChangedRuns& came, const ChangedRuns& went,
                                              const DiffLattice& lattice, std::size_t max_features) {
  std::vector<Outlined> outlined = LargestOf(came, "came", max_features);
  std::vector<Outlined> gone = LargestOf(went, "went", max_features);
  std::move(gone.begin(), gone.end(), std::back_inserter(outlined));
  std::stable_sort(outlined.begin(), outlined.end(),
                   [](const Outlined& a, const Outlined& b) { return a.group.cells > b.group.cells; });
  if (outlined.size() > max_features)
    outlined.erase(outlined.begin() + static_cast<std::ptrdiff_t>(max_features), outlined.end());
  OutlineWriter writer(lattice);
  for (const Outlined& one : outlined) ENFILADE_RETURN_IF_ERROR(writer.Add(one));
  return std::move(writer).Finish();
}

}  // namespace enfilade::grid
