// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "client/sdk/api/world_trajectory.h"
#include "tests/e2e/campus/drive_truth.h"

namespace enfilade::testing {

// What the server has for one scan.
struct ScanPlace {
  TimeNs time = 0;
  std::string map;
  std::optional<Pose2> T_world_robot;
};

// By time.
std::vector<ScanPlace> PlacesOf(const std::vector<client::MappedStretch>& stretches);

// That of the scan at `time`, which may differ by 50 ms; nullptr: it is not mapped.
const ScanPlace* PlaceAt(const std::vector<ScanPlace>& places, TimeNs time);

// Metres driven up to each true pose.
std::vector<double> WayOf(const DriveTruth& truth);

// From true pose `i` to the next.
double SecondsAt(const DriveTruth& truth, std::size_t i);

}  // namespace enfilade::testing
