// SPDX-License-Identifier: Apache-2.0
#include "core/areas/rasterize_area.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/geometry/pose2.h"

namespace enfilade::areas {
namespace {

using Eigen::Vector2d;

// Frames that are turned and shifted round coordinates: what is this near to an edge, in cells, is on it.
constexpr double kOnEdge = 1e-6;

// Fills rows of a grid; columns and rows may be beyond it.
class RowFiller {
 public:
  RowFiller(const grid::GridGeometry& geometry, const VisitCells& visit) : geometry_(geometry), visit_(visit) {}

  // The rows in which [low, high] begins and ends, cut to the grid and one row beyond.
  std::pair<int, int> RowsOf(double low, double high) const {
    return {ToCell(std::max(low, 0.0), geometry_.height), ToCell(high, geometry_.height)};
  }
  // The cells whose centres are in [low, high].
  void FillCentres(int row, double low, double high) const {
    Fill(row, std::ceil(low - 0.5 - kOnEdge), std::floor(high - 0.5 + kOnEdge));
  }
  // The cells that [low, high] enters; one that it only meets at the cell's border is not entered.
  void FillEntered(int row, double low, double high) const { Fill(row, FirstEntered(low), LastEntered(high)); }
  static double FirstEntered(double low) { return std::floor(low + kOnEdge); }
  static double LastEntered(double high) { return std::ceil(high - kOnEdge) - 1.0; }
  int height() const { return geometry_.height; }

 private:
  // A double is cut before it becomes an integer: it may be beyond any integer.
  static int ToCell(double value, int end) {
    return static_cast<int>(std::clamp(std::floor(value), -1.0, static_cast<double>(end)));
  }
  void Fill(int row, double first, double last) const {
    if (row < 0 || row >= geometry_.height || last < 0.0 || first >= geometry_.width || first > last) return;
    visit_(row, ToCell(std::max(first, 0.0), geometry_.width),
           ToCell(std::min(last, static_cast<double>(geometry_.width - 1)), geometry_.width));
  }

  const grid::GridGeometry& geometry_;
  const VisitCells& visit_;
};

// The polygon in cells: column + 0.5, row + 0.5 is a cell's centre.
std::vector<Vector2d> InCells(const std::vector<Vector2d>& outline, const grid::GridGeometry& geometry) {
  const Pose2 T_grid_map = Inverse(geometry.T_map_grid);
  std::vector<Vector2d> corners;
  corners.reserve(outline.size());
  for (const Vector2d& corner : outline) corners.emplace_back((T_grid_map * corner) / geometry.resolution);
  return corners;
}

double ColumnAt(const Vector2d& from, const Vector2d& to, double y) {
  return from.x() + (to.x() - from.x()) * ((y - from.y()) / (to.y() - from.y()));
}

// Between each odd crossing of a row's middle and the next one is inside.
void FillInside(const std::vector<Vector2d>& corners, int first_row, int last_row, const RowFiller& filler) {
  std::vector<std::vector<double>> crossings(static_cast<std::size_t>(last_row - first_row + 1));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    Vector2d low = corners[i];
    Vector2d high = corners[(i + 1) % corners.size()];
    if (low.y() > high.y()) std::swap(low, high);
    const auto [from, to] = filler.RowsOf(low.y() - 0.5, high.y());
    for (int row = std::max(from, first_row); row <= std::min(to, last_row); ++row) {
      const double y = row + 0.5;
      if (low.y() <= y && y < high.y()) {
        crossings[static_cast<std::size_t>(row - first_row)].push_back(ColumnAt(low, high, y));
      }
    }
  }
  for (int row = first_row; row <= last_row; ++row) {
    std::vector<double>& columns = crossings[static_cast<std::size_t>(row - first_row)];
    std::sort(columns.begin(), columns.end());
    for (std::size_t i = 0; i + 1 < columns.size(); i += 2) filler.FillCentres(row, columns[i], columns[i + 1]);
  }
}

// Centres on sides along a row, and at corners, which lie between two crossings of a row's middle at most by chance.
void FillOnEdge(const std::vector<Vector2d>& corners, const RowFiller& filler) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d& corner = corners[i];
    const Vector2d& next = corners[(i + 1) % corners.size()];
    const double row = std::round(corner.y() - 0.5);
    if (std::abs(corner.y() - 0.5 - row) > kOnEdge || row < 0.0 || row >= filler.height()) continue;
    const bool along_row = std::abs(next.y() - corner.y()) <= kOnEdge;
    const auto [low, high] = std::minmax({corner.x(), along_row ? next.x() : corner.x()});
    filler.FillCentres(static_cast<int>(row), low, high);
  }
}

void FillEnteredBySides(const std::vector<Vector2d>& corners, const RowFiller& filler) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    Vector2d low = corners[i];
    Vector2d high = corners[(i + 1) % corners.size()];
    if (low.y() > high.y()) std::swap(low, high);
    const bool along_row = high.y() - low.y() <= kOnEdge;
    const auto [from, to] = filler.RowsOf(RowFiller::FirstEntered(low.y()), RowFiller::LastEntered(high.y()));
    for (int row = from; row <= to; ++row) {
      const double a = along_row ? low.x() : ColumnAt(low, high, std::clamp<double>(row, low.y(), high.y()));
      const double b = along_row ? high.x() : ColumnAt(low, high, std::clamp<double>(row + 1.0, low.y(), high.y()));
      filler.FillEntered(row, std::min(a, b), std::max(a, b));
    }
  }
}

}  // namespace

void RasterizeArea(const std::vector<Vector2d>& outline, const grid::GridGeometry& geometry, AreaCells cells,
                   const VisitCells& visit) {
  const std::vector<Vector2d> corners = InCells(outline, geometry);
  const RowFiller filler(geometry, visit);
  double low = corners.front().y();
  double high = low;
  for (const Vector2d& corner : corners) {
    low = std::min(low, corner.y());
    high = std::max(high, corner.y());
  }
  if (high < 0.0 || low > geometry.height) return;
  const auto [first_row, last_row] = filler.RowsOf(low - 0.5, high);
  FillInside(corners, first_row, last_row, filler);
  FillOnEdge(corners, filler);
  if (cells == AreaCells::kEntered) FillEnteredBySides(corners, filler);
}

}  // namespace enfilade::areas
