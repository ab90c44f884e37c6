// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "enfilade/v1/map_area.pb.h"
#include "google/protobuf/field_mask.pb.h"
#include "google/protobuf/timestamp.pb.h"

namespace enfilade::cli {

// What people give of an area on the command line.
struct AreaFields {
  std::optional<std::string> name;
  std::optional<std::string> kind;
  std::optional<std::string> polygon;    // "X,Y X,Y X,Y ..."
  std::vector<std::string> robot_types;  // empty: not given
  bool all_robots = false;
  std::optional<double> speed;  // m/s
  std::optional<std::string> from;
  std::optional<std::string> until;
};

void AddAreaFields(CLI::App& command, AreaFields& fields);

// A time as in 2026-01-31T08:00:00Z. INVALID_ARGUMENT naming `option`.
absl::StatusOr<google::protobuf::Timestamp> ParseTimeOption(const char* option, const std::string& text);

// Sets what was given, and names it in the mask. INVALID_ARGUMENT.
absl::Status FillArea(const AreaFields& fields, v1::MapArea& area, google::protobuf::FieldMask& mask);

}  // namespace enfilade::cli
