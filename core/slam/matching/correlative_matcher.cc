// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/correlative_matcher.h"

#include <algorithm>
#include <cmath>

namespace enfilade::slam {
namespace {

constexpr double kPriorWeight = 0.02;  // one sigma away costs as much as 2 % of the points
constexpr double kRounding = 1e-9;     // of a score

// The points as cells, with the robot at the window's centre and one of the searched yaws.
struct TurnedScan {
  double yaw = 0.0;
  double prior_cost = 0.0;
  std::vector<grid::CellIndex> cells;
};

// A block of 2^level x 2^level offsets (in cells) of one turned scan.
struct Candidate {
  int scan = 0;
  int level = 0;
  int dx = 0;
  int dy = 0;
  double bound = 0.0;
};

class Search {
 public:
  Search(const SearchTable& table, const std::vector<Eigen::Vector2d>& points, const SearchWindow& window)
      : table_(table), window_(window), reach_(static_cast<int>(std::ceil(window.half_width / table.resolution()))) {
    inverse_ = 1.0 / (255.0 * static_cast<double>(points.size()));
    TurnScan(points);
  }

  SearchResult Run() {
    const int top = TopLevel();
    const int size = 1 << top;
    std::vector<Candidate> roots;
    for (int scan = 0; scan < static_cast<int>(scans_.size()); ++scan) {
      for (int dy = -reach_; dy <= reach_; dy += size) {
        for (int dx = -reach_; dx <= reach_; dx += size) {
          const Candidate root{scan, top, dx, dy, 0.0};
          if (!IsExcluded(root)) roots.push_back(Bounded(root));
        }
      }
    }
    best_.bound = window_.min_score > 0.0 ? window_.min_score : -1e9;
    if (window_.relevant_score > 0.0) {
      best_.bound = std::max(best_.bound, window_.relevant_score - HighestPriorCost() - kRounding);
    }
    best_.level = -1;
    Descend(roots);
    if (best_.level < 0) return {window_.centre, 0.0};
    const TurnedScan& scan = scans_[static_cast<std::size_t>(best_.scan)];
    const double r = table_.resolution();
    return {{window_.centre.x + best_.dx * r, window_.centre.y + best_.dy * r, WrapAngle(scan.yaw)},
            best_.bound + PriorCost(best_)};
  }

 private:
  int TopLevel() const {
    int level = 0;
    while (level + 1 < table_.levels() && (1 << (level + 1)) <= reach_) ++level;
    return level;
  }

  // One scan per yaw. From yaw to yaw, points at the 90th percentile of range move by about one cell.
  void TurnScan(const std::vector<Eigen::Vector2d>& points) {
    std::vector<double> ranges;
    for (const Eigen::Vector2d& p : points) ranges.push_back(p.norm());
    const auto far = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() * 9 / 10);
    std::nth_element(ranges.begin(), far, ranges.end());
    const double step = std::clamp(table_.resolution() / std::max(*far, 1e-3), 0.005, 0.05);
    const double half = std::min(window_.half_angle, M_PI);
    const int steps = static_cast<int>(std::ceil(half / step));
    for (int k = -steps; k <= steps; ++k) {
      TurnedScan scan;
      const double turn = half * k / std::max(steps, 1);
      scan.yaw = window_.centre.yaw + turn;
      scan.prior_cost = kPriorWeight * turn * turn / (window_.sigma_yaw * window_.sigma_yaw);
      const double c = std::cos(scan.yaw) / table_.resolution();
      const double s = std::sin(scan.yaw) / table_.resolution();
      const double x = window_.centre.x / table_.resolution();
      const double y = window_.centre.y / table_.resolution();
      scan.cells.reserve(points.size());
      for (const Eigen::Vector2d& p : points) {
        const grid::CellIndex cell{static_cast<int>(std::floor(x + c * p.x() - s * p.y())),
                                   static_cast<int>(std::floor(y + s * p.x() + c * p.y()))};
        scan.cells.push_back(cell);
      }
      scans_.push_back(std::move(scan));
    }
  }

  // The lowest prior cost in the candidate's block.
  double PriorCost(const Candidate& candidate) const {
    const int last = (1 << candidate.level) - 1;
    const double dx = std::max({candidate.dx, -(candidate.dx + last), 0}) * table_.resolution();
    const double dy = std::max({candidate.dy, -(candidate.dy + last), 0}) * table_.resolution();
    return scans_[static_cast<std::size_t>(candidate.scan)].prior_cost +
           kPriorWeight * (dx * dx + dy * dy) / (window_.sigma_translation * window_.sigma_translation);
  }

  // Of all poses in the window.
  double HighestPriorCost() const {
    const double far = reach_ * table_.resolution() / window_.sigma_translation;
    return scans_.front().prior_cost + kPriorWeight * 2.0 * far * far;
  }

  Candidate Bounded(Candidate candidate) const {
    const SearchTable::View view = table_.ViewOf(candidate.level);
    int sum = 0;
    for (const grid::CellIndex& cell : scans_[static_cast<std::size_t>(candidate.scan)].cells) {
      sum += view.At((cell.column + candidate.dx) >> candidate.level, (cell.row + candidate.dy) >> candidate.level);
    }
    candidate.bound = sum * inverse_ - PriorCost(candidate);
    return candidate;
  }

  // Whether all poses of the candidate's block are. Otherwise the search would look at each of them: the surroundings
  // of the best pose score higher than all that is sought.
  bool IsExcluded(const Candidate& candidate) const {
    if (!window_.excluded) return false;
    const double yaw = scans_[static_cast<std::size_t>(candidate.scan)].yaw - window_.excluded->yaw;
    if (std::abs(WrapAngle(yaw)) >= window_.excluded_angle) return false;
    const int last = (1 << candidate.level) - 1;
    const double r = table_.resolution();
    const auto farthest = [&](double centre, int offset, double excluded) {
      return std::max(std::abs(centre + offset * r - excluded), std::abs(centre + (offset + last) * r - excluded));
    };
    return std::hypot(farthest(window_.centre.x, candidate.dx, window_.excluded->x),
                      farthest(window_.centre.y, candidate.dy, window_.excluded->y)) < window_.excluded_distance;
  }

  // Depth first, best bound first. Ties go to the candidate created first, so that the result is deterministic.
  void Descend(std::vector<Candidate>& candidates) {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.bound > b.bound; });
    for (const Candidate& candidate : candidates) {
      if (candidate.bound <= best_.bound) return;
      if (candidate.level == 0) {
        best_ = candidate;
        return;
      }
      std::vector<Candidate> parts;
      const int half = 1 << (candidate.level - 1);
      for (const int dy : {candidate.dy, candidate.dy + half}) {
        for (const int dx : {candidate.dx, candidate.dx + half}) {
          if (dx > reach_ || dy > reach_) continue;
          const Candidate part{candidate.scan, candidate.level - 1, dx, dy, 0.0};
          if (!IsExcluded(part)) parts.push_back(Bounded(part));
        }
      }
      Descend(parts);
    }
  }

  const SearchTable& table_;
  SearchWindow window_;
  int reach_;
  double inverse_;
  std::vector<TurnedScan> scans_;
  Candidate best_;
};

}  // namespace

SearchResult SearchPose(const SearchTable& table, const std::vector<Eigen::Vector2d>& points,
                        const SearchWindow& window) {
  if (points.empty()) return {window.centre, 0.0};
  return Search(table, points, window).Run();
}

}  // namespace enfilade::slam
