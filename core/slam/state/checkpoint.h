// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {

// The part of `state` that is not in the stored rows.
std::string EncodeCheckpoint(const MapperState& state);

// The state from the checkpoint and the rows stored with it. DATA_LOSS if the checkpoint is damaged or belongs to other
// rows.
absl::StatusOr<MapperState> DecodeCheckpoint(std::string_view checkpoint, const SlamMap& stored,
                                             const OccupancyOptions& options);

// Of a checkpoint alone, without the stored rows. DATA_LOSS if it is damaged.
absl::StatusOr<ErrorStatistics> DecodeErrors(std::string_view checkpoint);

}  // namespace enfilade::slam
