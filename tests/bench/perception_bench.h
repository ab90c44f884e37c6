// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace enfilade::bench {

std::string ReadAll(const std::filesystem::path& path);

// Medians of one call over `repeats`: {"ms": by the clock, "processor_ms": of all threads}. On a machine that does
// other things too the second is the one to compare.
nlohmann::json Time(int repeats, const std::function<void()>& work);

// Each looks below `data` for its recordings and gives null where they are not there.
nlohmann::json MeasureCorridor(const std::filesystem::path& data);       // images/rtabmap_samples
nlohmann::json MeasureWideBaselines(const std::filesystem::path& data);  // images/scannet_pairs
nlohmann::json MeasureSimulatedCorridors();  // of the same place, and of places ahead in the same corridor
nlohmann::json MeasureOverlaps(const std::filesystem::path& data);  // images/sevenscenes
nlohmann::json MeasureClouds(const std::filesystem::path& data);    // clouds/small_gicp, clouds/pcl

}  // namespace enfilade::bench
