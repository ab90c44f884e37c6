// SPDX-License-Identifier: Apache-2.0
#include "core/localization/pose_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>

#include "core/base/status_macros.h"

namespace enfilade::localization {
namespace {

constexpr double kMinYawStep = 0.01;  // rad
constexpr double kMaxYawStep = 0.05;
constexpr std::size_t kPointsAtOnce = 16;
constexpr int kAskEvery = 4096;  // blocks

// The points as cells, seen from a robot in cell (0, 0) with one of the searched headings.
struct TurnedPoints {
  double yaw = 0.0;
  std::vector<grid::CellIndex> cells;
};

// The poses of one heading with the robot in a block of 2^level x 2^level cells.
struct Block {
  double bound = 0.0;  // on the score of all its poses
  std::int32_t heading = 0;
  std::int32_t level = 0;
  std::int32_t column = 0;
  std::int32_t row = 0;
};

struct IsWorse {
  bool operator()(const Block& a, const Block& b) const {
    if (a.bound != b.bound) return a.bound < b.bound;
    if (a.level != b.level) return a.level > b.level;  // finish what is begun
    if (a.heading != b.heading) return a.heading > b.heading;
    return a.row != b.row ? a.row > b.row : a.column > b.column;
  }
};

class ModeSearch {
 public:
  ModeSearch(const SearchableMap& map, const std::vector<Eigen::Vector2d>& points,
             const std::optional<SearchArea>& area, const LocalizationOptions& options)
      : map_(map),
        options_(options),
        scale_(1.0 / (255.0 * static_cast<double>(points.size()))),
        off_ground_(area && area->off_ground) {
    for (const double yaw : HeadingsOf(points, area)) Turn(points, yaw);
  }

  absl::StatusOr<FoundPoses> Run(const slam::CellWindow& window, const KeepGoing& keep_going) {
    window_ = window;
    min_score_ = options_.min_score;
    PushRoots();
    FoundPoses found;
    for (int expansions = 0; !blocks_.empty(); ++expansions) {
      const Block block = blocks_.top();
      if (block.bound < min_score_) break;
      blocks_.pop();
      if (expansions >= options_.max_expansions || static_cast<int>(found.poses.size()) >= options_.max_modes) {
        found.complete = false;
        break;
      }
      if (expansions % kAskEvery == 0) ENFILADE_RETURN_IF_ERROR(keep_going());
      if (IsTaken(block, found.poses)) continue;
      if (block.level > 0) {
        Split(block);
        continue;
      }
      if (found.poses.empty()) min_score_ = std::max(min_score_, options_.min_relative_score * block.bound);
      found.poses.push_back({PoseOf(block), block.bound});
    }
    return found;
  }

 private:
  // From heading to heading, points at the 90th percentile of range move by about one and a half cells.
  std::vector<double> HeadingsOf(const std::vector<Eigen::Vector2d>& points,
                                 const std::optional<SearchArea>& area) const {
    const double r = map_.bounds().resolution();
    std::vector<double> ranges;
    for (const Eigen::Vector2d& p : points) ranges.push_back(p.norm());
    const auto far = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() * 9 / 10);
    std::nth_element(ranges.begin(), far, ranges.end());
    const double step = std::clamp(1.6 * r / std::max(*far, 1e-3), kMinYawStep, kMaxYawStep);
    std::vector<double> yaws;
    if (!area || area->half_yaw >= M_PI) {
      const int count = static_cast<int>(std::ceil(2.0 * M_PI / step));
      for (int i = 0; i < count; ++i) yaws.push_back(2.0 * M_PI * i / count - M_PI);
      return yaws;
    }
    const int steps = static_cast<int>(std::ceil(area->half_yaw / step));
    for (int i = -steps; i <= steps; ++i) yaws.push_back(area->yaw + area->half_yaw * i / std::max(steps, 1));
    return yaws;
  }

  void Turn(const std::vector<Eigen::Vector2d>& points, double yaw) {
    const double r = map_.bounds().resolution();
    TurnedPoints turned{yaw, {}};
    const Pose2 T_cell_robot{0.5 * r, 0.5 * r, yaw};
    for (const Eigen::Vector2d& p : points) {
      const Eigen::Vector2d q = T_cell_robot * p;
      turned.cells.push_back({static_cast<int>(std::floor(q.x() / r)), static_cast<int>(std::floor(q.y() / r))});
    }
    headings_.push_back(std::move(turned));
  }

  void PushRoots() {
    int top = 0;
    const int extent = std::max(window_.width, window_.height);
    while (top + 1 < map_.bounds().levels() && (1 << (top + 1)) <= extent) ++top;
    for (std::int32_t heading = 0; heading < static_cast<std::int32_t>(headings_.size()); ++heading) {
      for (int row = window_.min.row; row < window_.top(); row += 1 << top) {
        for (int column = window_.min.column; column < window_.right(); column += 1 << top) {
          Push({0.0, heading, top, column, row});
        }
      }
    }
  }

  void Push(Block block) {
    const int size = 1 << block.level;
    const slam::CellWindow cells = slam::Intersection({{block.column, block.row}, size, size}, window_);
    if (!off_ground_ && !map_.HasGround(cells)) return;
    const BoundTable::View view = map_.bounds().ViewOf(block.level);
    const std::vector<grid::CellIndex>& points = headings_[static_cast<std::size_t>(block.heading)].cells;
    // What the points missed so far may add up to before the block is out of the question.
    const double lossless = 255.0 * static_cast<double>(points.size());
    const int allowed = static_cast<int>(lossless - min_score_ / scale_);
    int missed = 0;
    for (std::size_t i = 0; i < points.size() && missed <= allowed;) {
      for (const std::size_t end = std::min(points.size(), i + kPointsAtOnce); i < end; ++i) {
        missed += 255 - view.At(points[i].column + block.column, points[i].row + block.row);
      }
    }
    if (missed > allowed) return;
    block.bound = scale_ * (lossless - missed);
    blocks_.push(block);
  }

  void Split(const Block& block) {
    const int half = 1 << (block.level - 1);
    for (const int row : {block.row, block.row + half}) {
      for (const int column : {block.column, block.column + half}) {
        Push({0.0, block.heading, block.level - 1, column, row});
      }
    }
  }

  // Whether all poses of the block are near one that was found, which is better.
  bool IsTaken(const Block& block, const std::vector<FoundPose>& found) const {
    const double r = map_.bounds().resolution();
    const double half = 0.5 * (1 << block.level) * r;
    const Eigen::Vector2d centre(block.column * r + half, block.row * r + half);
    const double reach = options_.mode_distance - std::sqrt(2.0) * (half - 0.5 * r);
    if (reach <= 0.0) return false;
    const double yaw = headings_[static_cast<std::size_t>(block.heading)].yaw;
    return std::any_of(found.begin(), found.end(), [&](const FoundPose& one) {
      return (one.T_map_robot.translation() - centre).squaredNorm() < reach * reach &&
             std::abs(WrapAngle(one.T_map_robot.yaw - yaw)) < options_.mode_angle;
    });
  }

  Pose2 PoseOf(const Block& leaf) const {
    const double r = map_.bounds().resolution();
    return {(leaf.column + 0.5) * r, (leaf.row + 0.5) * r,
            WrapAngle(headings_[static_cast<std::size_t>(leaf.heading)].yaw)};
  }

  const SearchableMap& map_;
  const LocalizationOptions& options_;
  double scale_;
  bool off_ground_;
  double min_score_ = 0.0;
  slam::CellWindow window_;
  std::vector<TurnedPoints> headings_;
  std::priority_queue<Block, std::vector<Block>, IsWorse> blocks_;
};

slam::CellWindow WindowOf(const SearchableMap& map, const std::optional<SearchArea>& area) {
  if (!area) return map.ground();
  const double r = map.bounds().resolution();
  const auto cell = [&](double at) { return static_cast<int>(std::floor(std::clamp(at, -1e7, 1e7) / r)); };
  const slam::CellWindow around =
      slam::WindowBetween(cell(area->centre.x() - area->radius), cell(area->centre.y() - area->radius),
                          cell(area->centre.x() + area->radius) + 1, cell(area->centre.y() + area->radius) + 1);
  return area->off_ground ? around : slam::Intersection(map.ground(), around);
}

}  // namespace

absl::StatusOr<FoundPoses> FindPoses(const SearchableMap& map, const std::vector<Eigen::Vector2d>& points,
                                     const std::optional<SearchArea>& area, const LocalizationOptions& options,
                                     const KeepGoing& keep_going) {
  if (points.empty() || map.empty()) return FoundPoses{};
  const slam::CellWindow window = WindowOf(map, area);
  if (window.empty()) return FoundPoses{};
  return ModeSearch(map, points, area, options).Run(window, keep_going);
}

}  // namespace enfilade::localization
