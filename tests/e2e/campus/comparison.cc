// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "fmt/format.h"
#include "fmt/ranges.h"
#include "tests/e2e/campus/scan_places.h"

namespace enfilade::testing {
namespace {

constexpr double kMostly = 0.1;  // of a stretch may be off before it counts as misplaced

// Which maps robots were in while they were in an area.
struct AreaTimes {
  std::map<std::string, double> maps;  // s, away from doors
  std::map<std::string, double> all;   // s, everywhere
  const std::map<std::string, double>& times() const { return maps.empty() ? all : maps; }
};

double TotalOf(const std::map<std::string, double>& times) {
  double total = 0.0;
  for (const auto& [map, seconds] : times) total += seconds;
  return total;
}

std::string MainOf(const std::map<std::string, double>& times) {
  const auto most =
      std::max_element(times.begin(), times.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == times.end() ? "" : most->first;
}

double DistanceTo(const TrueDoor& door, const Eigen::Vector2d& point) {
  const Eigen::Vector2d along = door.b - door.a;
  const double t = std::clamp(along.dot(point - door.a) / std::max(along.squaredNorm(), 1e-9), 0.0, 1.0);
  return (point - door.a - t * along).norm();
}

class Comparer {
 public:
  Comparer(const std::vector<DriveTruth>& truths, const std::vector<TrueDoor>& doors, const MappedState& state,
           const ComparisonOptions& options)
      : truths_(truths), doors_(doors), state_(state), options_(options) {
    if (truths.empty()) throw std::runtime_error("no drives to compare with");
    for (const DriveTruth& truth : truths) {
      const auto stretches = state.stretches.find(truth.robot);
      places_.push_back(stretches == state.stretches.end() ? std::vector<ScanPlace>() : PlacesOf(stretches->second));
    }
  }

  Comparison Run() {
    Align();
    for (std::size_t i = 0; i < truths_.size(); ++i) {
      CollectAreas(truths_[i], places_[i]);
      ComparePoses(truths_[i], places_[i]);
    }
    DropGaps();
    if (poses_ > 0) result_.position_rms = std::sqrt(squares_ / poses_);
    CompareAreas();
    if (options_.doors) CompareDoors();
    Conclude();
    return result_;
  }

 private:
  // The world in the campus, by the first scan that has a place.
  void Align() {
    for (std::size_t i = 0; i < truths_.size(); ++i) {
      for (const ScanPlace& place : places_[i]) {
        if (!place.T_world_robot) continue;
        result_.T_campus_world = TruthAt(truths_[i], place.time) * Inverse(*place.T_world_robot);
        return;
      }
    }
  }

  void CollectAreas(const DriveTruth& truth, const std::vector<ScanPlace>& places) {
    const std::vector<double> way = WayOf(truth);
    std::vector<double> passed;  // at which metre
    for (const PassedDoor& passage : truth.passages) {
      const auto after = std::lower_bound(truth.poses.begin(), truth.poses.end(), passage.time,
                                          [](const TruePoint& point, TimeNs at) { return point.time < at; });
      passed.push_back(after == truth.poses.end() ? way.back()
                                                  : way[static_cast<std::size_t>(after - truth.poses.begin())]);
    }
    for (std::size_t i = 0; i < truth.poses.size(); ++i) {
      if (truth.poses[i].area.empty()) continue;
      AreaTimes& area = areas_[truth.poses[i].area];
      const ScanPlace* place = PlaceAt(places, truth.poses[i].time);
      const double seconds = SecondsAt(truth, i);
      if (!place || place->map.empty()) continue;
      area.all[place->map] += seconds;
      const bool near = std::any_of(passed.begin(), passed.end(), [&](double at) {
        return way[i] > at - options_.before_door && way[i] < at + options_.behind_door;
      });
      if (!near) area.maps[place->map] += seconds;
    }
  }

  // An area that nobody passed a door to, and that was driven over at once, is a gap between two doors: of a lift's
  // cabin and of its shaft.
  void DropGaps() {
    std::set<std::string> entered;
    for (const DriveTruth& truth : truths_) {
      for (const PassedDoor& passage : truth.passages) entered.insert({passage.from, passage.to});
    }
    std::erase_if(areas_, [&](const auto& area) {
      return !entered.contains(area.first) && TotalOf(area.second.all) <= options_.seconds;
    });
  }

  void ComparePoses(const DriveTruth& truth, const std::vector<ScanPlace>& places) {
    std::size_t passage = 0;
    int scans = 0;
    int off = 0;
    const auto end_stretch = [&] {
      ++result_.stretches;
      if (off > kMostly * scans) {
        ++result_.false_placements;
        result_.wrong.push_back(
            fmt::format("{} is misplaced {}", truth.robot,
                        passage == 0 ? "at its start" : "behind " + truth.passages[passage - 1].door));
      }
      scans = off = 0;
    };
    for (std::size_t i = 0; i < truth.poses.size(); ++i) {
      const TruePoint& point = truth.poses[i];
      for (; passage < truth.passages.size() && truth.passages[passage].time <= point.time; ++passage) end_stretch();
      const ScanPlace* place = PlaceAt(places, point.time);
      if (!place) {
        result_.unmapped_s += SecondsAt(truth, i);
      } else if (!place->T_world_robot) {
        result_.unplaced_s += SecondsAt(truth, i);
      } else {
        ++scans;
        off += IsOff(point.T_campus_robot, result_.T_campus_world * *place->T_world_robot) ? 1 : 0;
      }
    }
    end_stretch();
    result_.passages += static_cast<int>(truth.passages.size());
  }

  bool IsOff(const Pose2& truth, const Pose2& estimate) {
    const double metres = (estimate.translation() - truth.translation()).norm();
    const double turn = std::abs(WrapAngle(estimate.yaw - truth.yaw));
    result_.position_max = std::max(result_.position_max, metres);
    result_.yaw_max = std::max(result_.yaw_max, turn);
    squares_ += metres * metres;
    ++poses_;
    return metres > options_.misplaced || turn > options_.misturned;
  }

  void CompareAreas() {
    std::map<std::string, std::vector<std::string>> owners;  // map -> the areas whose main map it is
    for (const auto& [id, area] : areas_) {
      const std::string main = MainOf(area.times());
      const double total = TotalOf(area.times());
      std::set<std::string>& maps = maps_of_[id];
      if (!main.empty()) maps.insert(main);
      for (const auto& [map, seconds] : area.times()) {
        if (seconds > options_.share * total && seconds > options_.seconds) maps.insert(map);
      }
      if (maps.size() > 1) {
        ++result_.areas_doubled;
        result_.wrong.push_back(fmt::format("area {} has {} maps ({})", id, maps.size(), SharesOf(area, maps)));
      }
      if (main.empty()) {
        ++result_.areas_missing;
        result_.wrong.push_back(fmt::format("area {} has no map", id));
      } else {
        owners[main].push_back(id);
      }
    }
    for (const auto& [map, areas] : owners) {
      result_.areas_missing += static_cast<int>(areas.size()) - 1;
      result_.maps_merged += areas.size() > 1 ? 1 : 0;
      if (areas.size() > 1) result_.wrong.push_back(fmt::format("areas {} are one map", fmt::join(areas, ", ")));
    }
    result_.areas = static_cast<int>(areas_.size());
    result_.maps = static_cast<int>(state_.maps.size());
    result_.maps_extra = result_.maps - static_cast<int>(owners.size());
  }

  // "M0" 61 %, "Map 3" 39 %
  std::string SharesOf(const AreaTimes& area, const std::set<std::string>& maps) const {
    std::vector<std::string> shares;
    for (const std::string& map : maps) {
      const double share = 100.0 * area.times().at(map) / TotalOf(area.times());
      shares.push_back(fmt::format("\"{}\" {:.0f} %", NameOf(map), share));
    }
    return fmt::format("{}", fmt::join(shares, ", "));
  }
  std::string NameOf(const std::string& map) const {
    for (const auto& [robot, stretches] : state_.stretches) {
      for (const client::MappedStretch& stretch : stretches) {
        if (stretch.map == map && !stretch.map_name.empty()) return stretch.map_name;
      }
    }
    return map;
  }

  // Whether the link point joins the two areas of a passage, in one direction or the other.
  bool Joins(const MappedLinkPoint& point, const std::pair<std::string, std::string>& areas) {
    const std::set<std::string>& from = maps_of_[areas.first];
    const std::set<std::string>& to = maps_of_[areas.second];
    for (const std::string& a : point.maps) {
      for (const std::string& b : point.maps) {
        if (a != b && from.contains(a) && to.contains(b)) return true;
      }
    }
    return false;
  }

  void CompareDoors() {
    std::map<std::string, std::pair<std::string, std::string>> passed;  // door -> its areas
    for (const DriveTruth& truth : truths_) {
      for (const PassedDoor& passage : truth.passages) passed[passage.door] = {passage.from, passage.to};
    }
    std::map<std::string, int> right;
    for (const MappedLinkPoint& point : state_.link_points) {
      if (!point.joins) continue;
      ++result_.joins;
      std::string nearest_right;
      double nearest = std::numeric_limits<double>::infinity();
      bool at_a_door = false;
      for (const TrueDoor& door : doors_) {
        if (!point.world || !passed.contains(door.id)) continue;
        const double distance =
            DistanceTo(door, (result_.T_campus_world * Pose2{point.world->x(), point.world->y(), 0.0}).translation());
        if (distance > options_.at_door) continue;
        at_a_door = true;
        if (distance >= nearest || !Joins(point, passed[door.id])) continue;
        nearest = distance;
        nearest_right = door.id;
      }
      if (!nearest_right.empty()) {
        ++right[nearest_right];
      } else {
        ++(at_a_door ? result_.joins_wrong : result_.joins_false);
      }
    }
    for (const auto& [door, areas] : passed) {
      if (right[door] == 0) result_.wrong.push_back(fmt::format("door {} is not there", door));
      if (right[door] > 1) result_.wrong.push_back(fmt::format("door {} exists {} times", door, right[door]));
      result_.doors_missing += right[door] == 0 ? 1 : 0;
      result_.doors_doubled += right[door] > 1 ? 1 : 0;
    }
    result_.doors = static_cast<int>(passed.size());
  }

  void Conclude() {
    result_.candidates = state_.candidates();
    result_.components = state_.components();
    if (result_.joins_wrong > 0) result_.wrong.push_back(fmt::format("{} joins of wrong maps", result_.joins_wrong));
    if (result_.joins_false > 0) result_.wrong.push_back(fmt::format("{} joins at no door", result_.joins_false));
    if (result_.maps_extra > 0) result_.wrong.push_back(fmt::format("{} maps too many", result_.maps_extra));
    if (result_.components > 1) result_.wrong.push_back(fmt::format("{} pieces", result_.components));
    const bool all_passed = result_.doors == static_cast<int>(doors_.size());
    if (all_passed && result_.candidates > 0) result_.wrong.push_back("candidates are left");
    result_.exact = result_.wrong.empty();
  }

  const std::vector<DriveTruth>& truths_;
  const std::vector<TrueDoor>& doors_;
  const MappedState& state_;
  const ComparisonOptions options_;
  std::vector<std::vector<ScanPlace>> places_;  // of each robot
  std::map<std::string, AreaTimes> areas_;
  std::map<std::string, std::set<std::string>> maps_of_;
  double squares_ = 0.0;
  int poses_ = 0;
  Comparison result_;
};

}  // namespace

Comparison Compare(const std::vector<DriveTruth>& truths, const std::vector<TrueDoor>& doors, const MappedState& state,
                   const ComparisonOptions& options) {
  return Comparer(truths, doors, state, options).Run();
}

}  // namespace enfilade::testing
