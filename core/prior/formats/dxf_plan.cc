// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/dxf_plan.h"

#include <cmath>
#include <cstdint>
#include <optional>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/dxf_groups.h"
#include "core/prior/formats/plan_lines.h"
#include "core/prior/plan/plan_check.h"

namespace enfilade::prior {
namespace {

using Eigen::Affine2d;
using Eigen::Vector2d;

// AutoCAD's values of $INSUNITS.
std::optional<double> MetresOf(double insert_units) {
  switch (static_cast<int>(insert_units)) {
    case 1:
      return 0.0254;
    case 2:
      return 0.3048;
    case 4:
      return 0.001;
    case 5:
      return 0.01;
    case 6:
      return 1.0;
    case 7:
      return 1000.0;
    case 10:
      return 0.9144;
    case 14:
      return 0.1;
    default:
      return std::nullopt;
  }
}

struct PolylinePoint {
  Vector2d p = Vector2d::Zero();
  double bulge = 0;  // the tangent of a quarter of the arc's angle to the next point
};

class DxfReader {
 public:
  DxfReader(const DxfFile& file, const std::vector<std::string>& layers) : file_(file), layers_(layers) {
    metres_ = MetresOf(file.insert_units);
    sagitta_ = metres_ ? 0.02 / *metres_ : 0;
  }

  absl::StatusOr<VectorPlan> Read() {
    Affine2d turned_over = Affine2d::Identity();
    turned_over.scale(Vector2d(1, -1));
    ENFILADE_RETURN_IF_ERROR(ReadEntities(file_.entities, turned_over, {0, {}}));
    VectorPlan plan{lines_.TakePlan(), {}};
    plan.graph.metres_per_unit = metres_;
    if (!metres_) plan.warnings.push_back("the drawing has no unit ($INSUNITS)");
    return plan;
  }

 private:
  static constexpr int kDeepest = 8;
  static constexpr std::int64_t kMostGroups = 50'000'000;  // each as often as its block is inserted

  // Where entities stand: within how many blocks, and the layer of the innermost insertion.
  struct Place {
    int depth = 0;
    std::string_view layer;
  };

  // A block's lines on layer 0 take the layer that the block is inserted on.
  static std::string_view LayerOf(const DxfEntity& entity, const Place& place) {
    const std::string_view layer = entity.Text(8);
    return place.depth > 0 && layer == "0" ? place.layer : layer;
  }

  absl::Status ReadEntities(const std::vector<DxfEntity>& entities, const Affine2d& T, const Place& place) {
    for (std::size_t i = 0; i < entities.size(); ++i) {
      const DxfEntity& entity = entities[i];
      ENFILADE_RETURN_IF_ERROR(lines_.status());
      groups_ += 1 + static_cast<std::int64_t>(entity.groups.size());
      if (place.depth > 0 && groups_ > kMostGroups)
        return ResourceExhausted("more than {} DXF groups in inserted blocks", kMostGroups);
      if (entity.type == "INSERT") {
        ENFILADE_RETURN_IF_ERROR(ReadInsert(entity, T, place));
        continue;
      }
      const bool wanted = IsWantedLayer(layers_, LayerOf(entity, place));
      if (entity.type == "POLYLINE") {
        std::vector<PolylinePoint> points;
        for (; i + 1 < entities.size() && entities[i + 1].type == "VERTEX"; ++i) {
          points.push_back({PointOf(entities[i + 1], 10), entities[i + 1].Number(42)});
        }
        if (wanted) AddPolyline(points, IsClosed(entity), T, entity.Number(40));
      } else if (wanted) {
        ReadShape(entity, T);
      }
    }
    return lines_.status();
  }

  // Each block that is inserted counts, so that blocks of blocks cannot multiply without end.
  absl::Status ReadInsert(const DxfEntity& entity, const Affine2d& T, const Place& place) {
    const auto block = file_.blocks.find(entity.Text(2));
    if (block == file_.blocks.end()) return absl::OkStatus();
    constexpr int kMostInserts = 100'000;
    if (place.depth >= kDeepest) {
      return InvalidArgument("block \"{}\": more than {} blocks within each other", block->first, kDeepest);
    }
    if (++inserts_ > kMostInserts) return ResourceExhausted("more than {} inserted blocks", kMostInserts);
    Affine2d T_block = T;
    T_block.translate(PointOf(entity, 10));
    T_block.rotate(entity.Number(50) * M_PI / 180);
    T_block.scale(Vector2d(entity.Number(41, 1), entity.Number(42, 1)));
    return ReadEntities(block->second, T_block, {place.depth + 1, LayerOf(entity, place)});
  }

  static Vector2d PointOf(const DxfEntity& entity, int code) { return {entity.Number(code), entity.Number(code + 10)}; }
  static bool IsClosed(const DxfEntity& entity) { return (static_cast<int>(entity.Number(70)) & 1) != 0; }

  void ReadShape(const DxfEntity& entity, const Affine2d& T) {
    if (entity.type == "LINE") {
      lines_.Add(T, {PointOf(entity, 10), PointOf(entity, 11)}, false, 0);
    } else if (entity.type == "LWPOLYLINE") {
      std::vector<PolylinePoint> points;
      for (const DxfGroup& group : entity.groups) {
        const double number = group.Number().value_or(0);
        if (group.code == 10) points.push_back({{number, 0}, 0});
        if (group.code == 20 && !points.empty()) points.back().p.y() = number;
        if (group.code == 42 && !points.empty()) points.back().bulge = number;
      }
      AddPolyline(points, IsClosed(entity), T, entity.Number(43));
    } else if (entity.type == "ARC") {
      const double radius = entity.Number(40);
      const double from = entity.Number(50) * M_PI / 180;
      double sweep = std::fmod(entity.Number(51) * M_PI / 180 - from, 2 * M_PI);
      if (sweep <= 0) sweep += 2 * M_PI;
      Affine2d T_arc = T;
      T_arc.translate(PointOf(entity, 10));
      lines_.Add(T_arc, ChordsOf({radius, radius}, from, sweep, sagitta_), false, 0);
    }
  }

  void AddPolyline(const std::vector<PolylinePoint>& points, bool closed, const Affine2d& T, double width) {
    std::vector<Vector2d> line;
    for (std::size_t i = 0; i < points.size() && line.size() <= kMostWalls; ++i) {
      line.push_back(points[i].p);
      const bool last = i + 1 == points.size();
      if (points[i].bulge == 0 || (last && !closed)) continue;
      AddBulge(points[i].p, points[last ? 0 : i + 1].p, points[i].bulge, line);
    }
    lines_.Add(T, line, closed, std::max(0.0, width));
  }

  // The arc's points between a and b.
  void AddBulge(const Vector2d& a, const Vector2d& b, double bulge, std::vector<Vector2d>& line) const {
    const Vector2d chord = b - a;
    if (!(chord.norm() > 0) || !std::isfinite(bulge) || std::abs(bulge) > 1e6) return;
    const Vector2d normal(-chord.y(), chord.x());
    const Vector2d centre = (a + b) / 2 + normal * ((1 - bulge * bulge) / (4 * bulge));
    const double radius = (a - centre).norm();
    const double from = std::atan2(a.y() - centre.y(), a.x() - centre.x());
    const std::vector<Vector2d> arc = ChordsOf({radius, radius}, from, 4 * std::atan(bulge), sagitta_);
    for (std::size_t i = 1; i + 1 < arc.size(); ++i) line.push_back(centre + arc[i]);
  }

  const DxfFile& file_;
  const std::vector<std::string>& layers_;
  std::optional<double> metres_;
  double sagitta_ = 0;
  PlanLines lines_;
  int inserts_ = 0;
  std::int64_t groups_ = 0;
};

}  // namespace

absl::StatusOr<VectorPlan> ReadDxfPlan(std::string_view text, const std::vector<std::string>& layers) {
  ENFILADE_ASSIGN_OR_RETURN(const DxfFile file, SplitDxf(text));
  return DxfReader(file, layers).Read();
}

}  // namespace enfilade::prior
