// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/building_tour.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/world/free_ground.h"
#include "client/simulator/world/world.h"
#include "core/base/error.h"

namespace enfilade::simulator {
namespace {

constexpr double kRide = 8.0;            // s
constexpr double kNextSight = 8.0;       // m: a place in an area is not so far from one that is visited
constexpr std::size_t kMostSights = 12;  // in an area
constexpr double kSpacing = 0.2;         // m between the places that are tried in an area

// A place to visit in an area.
struct Sight {
  std::string area;
  std::string level;
  Eigen::Vector2d at;
  double size;  // places tried in the area that are free
};

class TourPlanner {
 public:
  explicit TourPlanner(Campus& campus) : campus_(campus), world_(campus), lifts_(campus.lifts) {
    for (const auto& [level, height] : campus.levels) levels_.emplace_back(height, level);
    std::sort(levels_.begin(), levels_.end());
    for (const auto& [height, level] : levels_) grounds_.emplace(level, FreeGround(world_.level(level)));
    for (const Area& area : campus.areas) {
      if (!campus.FindLift(area.id)) AddSight(area);
    }
  }

  // Through the start's level, then through the others from the lowest on.
  absl::Status Plan() {
    const Sight* largest = nullptr;
    for (const Sight& sight : sights_) {
      if (sight.level != levels_[0].second && largest) continue;
      if (!largest || largest->level != levels_[0].second || sight.size > largest->size) largest = &sight;
    }
    if (!largest) return InvalidArgument("{}: there is no room for a robot in it", campus_.name);
    const Sight start = *largest;
    const std::vector<Sight> sights = sights_;
    if (!Tour("robot", start)) return InvalidArgument("{}: its start cannot be reached again", campus_.name);
    // The second robot begins in the same area, and goes through the levels the other way round, by other lifts.
    std::reverse(levels_.begin(), levels_.end());
    std::reverse(lifts_.begin(), lifts_.end());
    const Sight beside =
        *std::find_if(sights.rbegin(), sights.rend(), [&](const Sight& sight) { return sight.area == start.area; });
    sights_ = sights;
    Tour("robot2", beside);
    return absl::OkStatus();
  }

 private:
  // Adds the robot. False: it would not come back to its start.
  bool Tour(const std::string& id, const Sight& start) {
    robot_ = {};
    robot_.id = id;
    robot_.level = level_ = start.level;
    robot_.route.push_back(StepTo(start.at));
    VisitLevel();
    for (const auto& [height, level] : levels_) {
      if (level != level_ && HasSights(level) && Ride(level)) VisitLevel();
    }
    if (level_ != start.level) Ride(start.level);
    if (!GoTo(start.at)) return false;
    if (robot_.route.size() > 2) robot_.route.pop_back();  // the start itself, where a round begins
    if (robot_.route.size() < 2) robot_.route.push_back(StepTo(start.at));
    robot_.returns = true;
    campus_.robots.push_back(std::move(robot_));
    return true;
  }

  static RouteStep StepTo(const Eigen::Vector2d& point) {
    RouteStep step;
    step.point = point;
    return step;
  }
  const FreeGround& ground() const { return grounds_.at(level_); }

  // The free place that is nearest to the middle of the free places; in a large area others, far from each other.
  void AddSight(const Area& area) {
    Eigen::Vector2d lower = area.outline[0];
    Eigen::Vector2d upper = area.outline[0];
    for (const Eigen::Vector2d& corner : area.outline) {
      lower = lower.cwiseMin(corner);
      upper = upper.cwiseMax(corner);
    }
    std::vector<Eigen::Vector2d> places;
    const FreeGround& ground = grounds_.at(area.level);
    for (double x = lower.x(); x <= upper.x(); x += kSpacing) {
      for (double y = lower.y(); y <= upper.y(); y += kSpacing) {
        const Eigen::Vector2d place(x, y);
        const Area* holder = campus_.AreaAt(area.level, place);
        if (holder && holder->id == area.id && ground.IsFree(place)) places.push_back(place);
      }
    }
    if (places.empty()) return;
    const Eigen::Vector2d middle =
        std::accumulate(places.begin(), places.end(), Eigen::Vector2d(0.0, 0.0)) / static_cast<double>(places.size());
    const auto nearest = std::min_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
      return (a - middle).squaredNorm() < (b - middle).squaredNorm();
    });
    std::vector<Eigen::Vector2d> chosen = {*nearest};
    while (chosen.size() < kMostSights) {
      const auto distance = [&](const Eigen::Vector2d& place) {
        double least = std::numeric_limits<double>::infinity();
        for (const Eigen::Vector2d& sight : chosen) least = std::min(least, (place - sight).norm());
        return least;
      };
      const auto farthest = std::max_element(places.begin(), places.end(),
                                             [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
      if (distance(*farthest) < kNextSight) break;
      chosen.push_back(*farthest);
    }
    for (const Eigen::Vector2d& at : chosen) {
      sights_.push_back({area.id, area.level, at, static_cast<double>(places.size())});
    }
  }

  bool HasSights(const std::string& level) const {
    return std::any_of(sights_.begin(), sights_.end(), [&](const Sight& sight) { return sight.level == level; });
  }

  bool GoTo(const Eigen::Vector2d& point) {
    const Eigen::Vector2d from = Here();
    if ((point - from).norm() < 0.2) return true;
    const std::vector<Eigen::Vector2d> way = ground().Way(from, point);
    for (const Eigen::Vector2d& corner : way) robot_.route.push_back(StepTo(corner));
    return !way.empty();
  }

  // The last point of the route.
  Eigen::Vector2d Here() const {
    const auto last = std::find_if(robot_.route.rbegin(), robot_.route.rend(),
                                   [](const RouteStep& step) { return step.kind == RouteStep::Kind::kPoint; });
    return last->point;
  }

  // Sights of this level, the nearest first; those that cannot be reached are left out.
  void VisitLevel() {
    while (true) {
      auto nearest = sights_.end();
      for (auto sight = sights_.begin(); sight != sights_.end(); ++sight) {
        if (sight->level != level_) continue;
        if (nearest == sights_.end() || (sight->at - Here()).norm() < (nearest->at - Here()).norm()) nearest = sight;
      }
      if (nearest == sights_.end()) return;
      const Eigen::Vector2d at = nearest->at;
      sights_.erase(nearest);
      GoTo(at);
    }
  }

  // By the first lift that goes there and can be reached.
  bool Ride(const std::string& level) {
    for (const Lift& lift : lifts_) {
      const auto stops = [&](const std::string& at) {
        return std::find(lift.levels.begin(), lift.levels.end(), at) != lift.levels.end();
      };
      if (!stops(level) || !stops(level_)) continue;
      const auto cabin = std::find_if(campus_.areas.begin(), campus_.areas.end(),
                                      [&](const Area& area) { return area.id == lift.id && area.level == level_; });
      const Eigen::Vector2d middle =
          std::accumulate(cabin->outline.begin(), cabin->outline.end(), Eigen::Vector2d(0.0, 0.0)) /
          static_cast<double>(cabin->outline.size());
      if (!GoTo(middle)) continue;
      RouteStep ride;
      ride.kind = RouteStep::Kind::kLift;
      ride.name = lift.id;
      ride.level = level;
      ride.value = kRide;
      robot_.route.push_back(ride);
      level_ = level;
      return true;
    }
    return false;
  }

  Campus& campus_;
  const World world_;
  std::vector<Lift> lifts_;                             // in the order in which they are tried
  std::vector<std::pair<double, std::string>> levels_;  // height, id; in the order in which they are visited
  std::map<std::string, FreeGround> grounds_;
  std::vector<Sight> sights_;  // still to visit
  Robot robot_;
  std::string level_;  // where the route is
};

}  // namespace

absl::Status PlanTour(Campus& campus) { return TourPlanner(campus).Plan(); }

}  // namespace enfilade::simulator
