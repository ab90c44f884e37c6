// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/scan_places.h"

#include <algorithm>
#include <utility>

namespace enfilade::testing {
namespace {

constexpr TimeNs kSameScan = 50'000'000;  // ns between a true pose and the mapped one

}  // namespace

std::vector<ScanPlace> PlacesOf(const std::vector<client::MappedStretch>& stretches) {
  std::vector<ScanPlace> places;
  for (const client::MappedStretch& stretch : stretches) {
    for (const client::MappedPose& pose : stretch.poses) {
      ScanPlace place{pose.time, stretch.map, std::nullopt};
      if (stretch.T_world_map) place.T_world_robot = *stretch.T_world_map * pose.T_map_robot;
      places.push_back(std::move(place));
    }
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const ScanPlace& a, const ScanPlace& b) { return a.time < b.time; });
  return places;
}

const ScanPlace* PlaceAt(const std::vector<ScanPlace>& places, TimeNs time) {
  const auto found = std::lower_bound(places.begin(), places.end(), time - kSameScan,
                                      [](const ScanPlace& place, TimeNs at) { return place.time < at; });
  return found != places.end() && found->time <= time + kSameScan ? &*found : nullptr;
}

std::vector<double> WayOf(const DriveTruth& truth) {
  std::vector<double> way = {0.0};
  for (std::size_t i = 1; i < truth.poses.size(); ++i) {
    way.push_back(
        way.back() +
        (truth.poses[i].T_campus_robot.translation() - truth.poses[i - 1].T_campus_robot.translation()).norm());
  }
  return way;
}

double SecondsAt(const DriveTruth& truth, std::size_t i) {
  return i + 1 < truth.poses.size() ? ToSeconds(truth.poses[i + 1].time - truth.poses[i].time) : 0.0;
}

}  // namespace enfilade::testing
