// SPDX-License-Identifier: Apache-2.0
#include "core/prior/ties/plan_frame.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

#include "core/base/disjoint_sets.h"

namespace enfilade::prior {
namespace {

constexpr double kJambReach = 0.5;    // m: a door's jamb is the end of a wall so near
constexpr double kSameCorner = 0.05;  // m: walls that end so near to each other meet

using graph::PlanStrut;

class Frame {
 public:
  Frame(const PlanGraph& plan, const PlanTransform& T_plan_sheet, const std::vector<char>& is_seen)
      : plan_(plan), is_seen_(is_seen) {
    std::vector<int> number;  // of each corner of the plan
    for (const PlanCorner& corner : plan.corners) {
      const Eigen::Vector2d point = T_plan_sheet(corner.point);
      const int known = NearestCorner(point, kSameCorner);
      number.push_back(known >= 0 ? known : static_cast<int>(corners_.size()));
      if (known >= 0) continue;
      corners_at_[CellOf(point)].push_back(number.back());
      corners_.push_back(point);
    }
    for (std::size_t i = 0; i < plan.walls.size(); ++i) {
      AddStrut({number[Index(plan.walls[i].from)], number[Index(plan.walls[i].to)], static_cast<int>(i)});
    }
    for (const PlanDoor& door : plan.doors) {
      AddStrut(
          {NearestCorner(T_plan_sheet(door.from), kJambReach), NearestCorner(T_plan_sheet(door.to), kJambReach), -1});
    }
  }

  PlanFrame Run() {
    DropUnseenParts();
    while (DropLooseEnds()) {
    }
    while (JoinParts()) {
    }
    return Compact();
  }

 private:
  static std::size_t Index(int corner) { return static_cast<std::size_t>(corner); }

  void AddStrut(const PlanStrut& strut) {
    if (strut.from >= 0 && strut.to >= 0 && strut.from != strut.to) struts_.push_back(strut);
  }

  // Squares of kJambReach.
  using Cell = std::pair<std::int64_t, std::int64_t>;
  static Cell CellOf(const Eigen::Vector2d& point) {
    return {std::llround(std::floor(point.x() / kJambReach)), std::llround(std::floor(point.y() / kJambReach))};
  }

  // -1: none is near. `reach`: at most kJambReach.
  int NearestCorner(const Eigen::Vector2d& point, double reach) const {
    int nearest = -1;
    double least = reach;
    const Cell cell = CellOf(point);
    for (std::int64_t x = cell.first - 1; x <= cell.first + 1; ++x) {
      for (std::int64_t y = cell.second - 1; y <= cell.second + 1; ++y) {
        const auto found = corners_at_.find({x, y});
        if (found == corners_at_.end()) continue;
        for (const int corner : found->second) {
          const double distance = (corners_[Index(corner)] - point).norm();
          if (distance >= least) continue;
          least = distance;
          nearest = corner;
        }
      }
    }
    return nearest;
  }

  bool IsSeen(const PlanStrut& strut) const { return strut.wall >= 0 && is_seen_[Index(strut.wall)] != 0; }

  // The corners that struts join.
  DisjointSets Parts() const {
    DisjointSets parts(corners_.size());
    for (const PlanStrut& strut : struts_) parts.Join(Index(strut.from), Index(strut.to));
    return parts;
  }

  void DropUnseenParts() {
    DisjointSets parts = Parts();
    std::vector<char> keep(corners_.size(), 0);
    for (const PlanStrut& strut : struts_) {
      if (IsSeen(strut)) keep[parts.Find(Index(strut.from))] = 1;
    }
    std::erase_if(struts_, [&](const PlanStrut& strut) { return keep[parts.Find(Index(strut.from))] == 0; });
  }

  bool DropLooseEnds() {
    std::vector<int> degree(corners_.size(), 0);
    for (const PlanStrut& strut : struts_) {
      ++degree[Index(strut.from)];
      ++degree[Index(strut.to)];
    }
    return std::erase_if(struts_, [&](const PlanStrut& strut) {
             return !IsSeen(strut) && (degree[Index(strut.from)] == 1 || degree[Index(strut.to)] == 1);
           }) > 0;
  }

  // Each part but the largest to the one that is nearest to it (Boruvka 1926). False if there is only one.
  bool JoinParts() {
    DisjointSets parts = Parts();
    std::vector<char> is_used(corners_.size(), 0);
    for (const PlanStrut& strut : struts_) is_used[Index(strut.from)] = is_used[Index(strut.to)] = 1;
    std::vector<int> used;                         // corners
    std::vector<int> size_of(corners_.size(), 0);  // by part
    for (int i = 0; i < static_cast<int>(corners_.size()); ++i) {
      if (is_used[Index(i)] == 0) continue;
      used.push_back(i);
      ++size_of[parts.Find(Index(i))];
    }
    const auto largest = static_cast<std::size_t>(std::max_element(size_of.begin(), size_of.end()) - size_of.begin());
    struct Way {
      double length = std::numeric_limits<double>::infinity();
      int from = -1, to = -1;
    };
    std::vector<Way> nearest(corners_.size());  // by part
    for (const int a : used) {
      const std::size_t part = parts.Find(Index(a));
      if (part == largest) continue;
      Way& way = nearest[part];
      for (const int b : used) {
        const double length = (corners_[Index(b)] - corners_[Index(a)]).norm();
        if (length < way.length && parts.Find(Index(b)) != part) way = {length, a, b};
      }
    }
    bool any = false;
    for (const Way& way : nearest) {
      if (way.from < 0 || !parts.Join(Index(way.from), Index(way.to))) continue;
      struts_.push_back({way.from, way.to, -1});
      any = true;
    }
    return any;
  }

  PlanFrame Compact() const {
    PlanFrame frame;
    frame.strut_of_wall.assign(plan_.walls.size(), -1);
    std::vector<int> number(corners_.size(), -1);
    const auto renumber = [&](int corner) {
      if (number[Index(corner)] < 0) {
        number[Index(corner)] = static_cast<int>(frame.corners.size());
        frame.corners.push_back(corners_[Index(corner)]);
      }
      return number[Index(corner)];
    };
    for (const PlanStrut& strut : struts_) {
      if (strut.wall >= 0) frame.strut_of_wall[Index(strut.wall)] = static_cast<int>(frame.struts.size());
      const int from = renumber(strut.from);
      frame.struts.push_back({from, renumber(strut.to), strut.wall});
    }
    return frame;
  }

  const PlanGraph& plan_;
  const std::vector<char>& is_seen_;
  std::vector<Eigen::Vector2d> corners_;
  std::map<Cell, std::vector<int>> corners_at_;
  std::vector<PlanStrut> struts_;
};

}  // namespace

PlanFrame FrameOf(const PlanGraph& plan, const PlanTransform& T_plan_sheet, const std::vector<char>& is_seen) {
  return Frame(plan, T_plan_sheet, is_seen).Run();
}

}  // namespace enfilade::prior
