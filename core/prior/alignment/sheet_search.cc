// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/sheet_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>

#include "core/grid/distance_field.h"

namespace enfilade::prior {
namespace {

constexpr double kSigma = 1.2;        // cells: how far a wall may be displaced
constexpr double kLargestMap = 1.25;  // of the sheet's walls, by their diameters: plans are wrong
constexpr double kSmallestMap = 0.2;
constexpr double kScaleStep = 1.05;
constexpr std::size_t kPeaks = 6;      // of one turn and scale
constexpr int kApart = 3;              // cells between two of them
constexpr double kFreeMargin = 0.3;    // m from the map's walls
constexpr double kFreeSpacing = 0.25;  // m
constexpr std::size_t kMostSearched = 3000;

// Half the longest diagonal of a set of points, robustly: of 98 % of them.
double RadiusAbout(const Eigen::Vector2d& centre, const std::vector<WallPoint>& walls) {
  std::vector<double> distances;
  distances.reserve(walls.size());
  for (const WallPoint& wall : walls) distances.push_back((wall.point - centre).norm());
  const auto at = distances.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(distances.size() - 1));
  std::nth_element(distances.begin(), at, distances.end());
  return *at;
}

Eigen::Vector2d MiddleOf(const std::vector<WallPoint>& walls) {
  Eigen::Vector2d min = walls.front().point;
  Eigen::Vector2d max = min;
  for (const WallPoint& wall : walls) {
    min = min.cwiseMin(wall.point);
    max = max.cwiseMax(wall.point);
  }
  return 0.5 * (min + max);
}

struct Peak {
  int column;
  int row;
  float score;
};

bool IsWorse(const Peak& a, const Peak& b) {
  if (a.score != b.score) return a.score < b.score;
  return a.row != b.row ? a.row > b.row : a.column > b.column;
}

// Places with a positive score that no neighbour exceeds. The image goes on at the opposite side.
std::vector<Peak> AllPeaks(const std::vector<float>& scores, int width, int height) {
  const auto row_at = [&](int row) { return scores.data() + static_cast<std::ptrdiff_t>(row) * width; };
  std::vector<Peak> peaks;
  for (int row = 0; row < height; ++row) {
    const float* const here = row_at(row);
    const float* const rows[] = {row_at(row == 0 ? height - 1 : row - 1), here,
                                 row_at(row + 1 == height ? 0 : row + 1)};
    for (int column = 0; column < width; ++column) {
      const float score = here[column];
      if (!(score > 0)) continue;
      const int left = column == 0 ? width - 1 : column - 1;
      const int right = column + 1 == width ? 0 : column + 1;
      const bool is_peak = std::all_of(std::begin(rows), std::end(rows), [&](const float* beside) {
        return score >= beside[left] && score >= beside[column] && score >= beside[right];
      });
      if (is_peak) peaks.push_back({column, row, score});
    }
  }
  return peaks;
}

// The best kPeaks, the best first.
std::vector<Peak> BestPeaks(const std::vector<float>& scores, int width, int height) {
  std::vector<Peak> heap = AllPeaks(scores, width, height);
  std::make_heap(heap.begin(), heap.end(), IsWorse);
  std::vector<Peak> best;
  while (!heap.empty() && best.size() < kPeaks) {
    std::pop_heap(heap.begin(), heap.end(), IsWorse);
    const Peak next = heap.back();
    heap.pop_back();
    const bool is_new = std::none_of(best.begin(), best.end(), [&](const Peak& other) {
      return std::hypot(other.column - next.column, other.row - next.row) < kApart;
    });
    if (is_new) best.push_back(next);
  }
  return best;
}

}  // namespace

SheetSearch::SheetSearch(const std::vector<WallFace>& faces_sheet, const MapEvidence& evidence, int cells)
    : evidence_(evidence) {
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());
  min_ = -max;
  for (const WallFace& face : faces_sheet) {
    min_ = min_.cwiseMin(face.from).cwiseMin(face.to);
    max = max.cwiseMax(face.from).cwiseMax(face.to);
  }
  size_ = max - min_;
  cell_ = size_.maxCoeff() / cells;

  map_centre_ = MiddleOf(evidence.walls);
  map_radius_ = RadiusAbout(map_centre_, evidence.walls);
  const std::size_t stride = evidence.walls.size() / kMostSearched + 1;
  for (std::size_t i = 0; i < evidence.walls.size(); i += stride) points_.push_back(evidence.walls[i]);
  const int step = std::max(1, static_cast<int>(kFreeSpacing / evidence.geometry.resolution));
  for (int row = 0; row < evidence.geometry.height; row += step) {
    for (int column = 0; column < evidence.geometry.width; column += step) {
      const std::size_t cell = evidence.geometry.index(column, row);
      if (evidence.ground[cell] != Ground::kFree || evidence.wall_distance[cell] < kFreeMargin) continue;
      const Eigen::Vector2d centre = evidence.geometry.resolution * Eigen::Vector2d(column + 0.5, row + 0.5);
      const double side = step * evidence.geometry.resolution;
      free_.push_back({evidence.geometry.T_map_grid * centre, static_cast<float>(side * side)});
    }
  }

  // Room for the largest map beside the sheet, so that nothing wraps around.
  const int map_cells = static_cast<int>(kLargestMap * size_.norm() / cell_) + 2;
  const int width = QuickSize(static_cast<int>(size_.x() / cell_) + 1 + map_cells);
  const int height = QuickSize(static_cast<int>(size_.y() / cell_) + 1 + map_cells);
  nearness_ = ComplexImage(width, height);
  length_ = ComplexImage(width, height);
  std::vector<std::uint8_t> walls(nearness_.values.size(), 0);
  for (std::size_t n = 0; n < faces_sheet.size(); ++n) {
    const WallFace& face = faces_sheet[n];
    const double length = (face.to - face.from).norm();
    const int pieces = std::max(1, static_cast<int>(std::ceil(2 * length / cell_)));
    // A wall with two faces, which are neighbours in the list, counts once.
    const bool doubled = (n > 0 && faces_sheet[n - 1].wall == face.wall) ||
                         (n + 1 < faces_sheet.size() && faces_sheet[n + 1].wall == face.wall);
    for (int i = 0; i < pieces; ++i) {
      const Eigen::Vector2d at = ToCells(face.from + (i + 0.5) / pieces * (face.to - face.from));
      const std::size_t cell = nearness_.index(std::min(width - 1, static_cast<int>(at.x())),
                                               std::min(height - 1, static_cast<int>(at.y())));
      walls[cell] = 1;
      length_.values[cell] += static_cast<float>(length / pieces * (doubled ? 0.5 : 1.0));
    }
  }
  const std::vector<float> distance = grid::DistancesTo(walls, width, height).distance;
  for (std::size_t i = 0; i < distance.size(); ++i) {
    const double d = distance[i] / kSigma;
    nearness_.values[i] = d < 4 ? static_cast<float>(std::exp(-0.5 * d * d)) : 0.0F;
  }
  Transform(nearness_);
  Transform(length_);
}

std::vector<double> SheetSearch::Scales() const {
  const double smallest = 2 * map_radius_ / (kLargestMap * size_.norm());
  const double largest = 2 * map_radius_ / (kSmallestMap * size_.norm());
  return ScalesBetween(smallest, largest);
}

std::vector<double> ScalesBetween(double least, double most) {
  std::vector<double> scales;
  for (double scale = least; scale <= most; scale *= kScaleStep) scales.push_back(scale);
  return scales;
}

std::vector<FoundTransform> SheetSearch::Find(const Eigen::Matrix2d& linear) const {
  const Eigen::Matrix2d to_cells = linear.inverse() / cell_;
  // The map about its centre: real part walls, imaginary part free ground (m^2 by cell area in m^2: a share).
  ComplexImage image(nearness_.width, nearness_.height);
  const double scale = std::sqrt(std::abs(linear.determinant()));
  const double cell_area = cell_ * cell_ * scale * scale;
  const auto wrap = [](double value, int size) {
    int at = static_cast<int>(value);
    if (value < at) --at;  // std::floor, which is slow here
    return at >= 0 && at < size ? at : ((at % size) + size) % size;
  };
  const auto index_of = [&](const Eigen::Vector2d& point) {
    const Eigen::Vector2d at = to_cells * (point - map_centre_);
    return image.index(wrap(at.x() + 0.5, image.width), wrap(at.y() + 0.5, image.height));
  };
  double weight = 0;
  for (const WallPoint& wall : points_) {
    image.values[index_of(wall.point)] += std::complex<float>(static_cast<float>(wall.straightness), 0);
    weight += wall.straightness;
  }
  for (const GroundPoint& ground : free_) {
    image.values[index_of(ground.point)] += std::complex<float>(0, static_cast<float>(ground.area / cell_area));
  }
  Transform(image);

  // Of two real images packed into one complex one, the transforms are the hermitian and antihermitian parts. Both
  // correlations come back packed the same way.
  const double wall_length = evidence_.wall_length();
  const auto to_metres = static_cast<float>(scale / wall_length);
  const auto to_share = static_cast<float>(1.0 / weight);
  ComplexImage product(image.width, image.height);
  for (int row = 0; row < image.height; ++row) {
    const int minus_row = row == 0 ? 0 : image.height - row;
    for (int column = 0; column < image.width; ++column) {
      const std::size_t k = image.index(column, row);
      const std::size_t minus_k = image.index(column == 0 ? 0 : image.width - column, minus_row);
      const std::complex<float> z = image.values[k];
      const std::complex<float> w = std::conj(image.values[minus_k]);
      const std::complex<float> walls = 0.5F * (z + w);
      const std::complex<float> free = std::complex<float>(0, -0.5F) * (z - w);
      product.values[k] = to_share * std::conj(walls) * nearness_.values[k] +
                          std::complex<float>(0, to_metres) * std::conj(free) * length_.values[k];
    }
  }
  TransformBack(product);

  std::vector<float> scores;
  scores.reserve(product.values.size());
  for (const std::complex<float>& value : product.values) scores.push_back(value.real() - std::min(1.0F, value.imag()));
  std::vector<FoundTransform> found;
  for (const Peak& peak : BestPeaks(scores, product.width, product.height)) {
    // The map's centre lies in this cell. Offsets beyond half of the image are negative.
    Eigen::Vector2d centre(peak.column, peak.row);
    if (centre.x() > product.width - 0.5 * (product.width - size_.x() / cell_)) centre.x() -= product.width;
    if (centre.y() > product.height - 0.5 * (product.height - size_.y() / cell_)) centre.y() -= product.height;
    const Eigen::Vector2d sheet = min_ + cell_ * (centre.array() + 0.5).matrix();
    found.push_back({{linear, map_centre_ - linear * sheet}, peak.score});
  }
  return found;
}

}  // namespace enfilade::prior
