// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"

namespace enfilade::sources {

// The content of the SQLite file of cmr_localization's map_manager (tables MAPS, LINKPOINTS, LINKPOINTCANDIDATES).

struct MapManagerMap {
  std::int64_t id = 0;
  std::string name;
  bool indoor = true;
};

// A row of LINKPOINTS or LINKPOINTCANDIDATES.
struct MapManagerPlace {
  struct Anchor {
    std::int64_t map = 0;
    Pose2 T_map_place;  // m, rad
  };
  std::int64_t id = 0;
  bool candidate = false;
  std::string tag;
  std::vector<Anchor> anchors;
  std::optional<std::int64_t> direction;  // the map entered when it was created
  int difficulty = 0;
  std::optional<bool> indoor;
  std::string front_image;  // PNG; may be empty
  std::string rear_image;
  std::string cloud;  // the bytes of its PCD file
};

// A row that was not imported, or only in part.
struct MapManagerRemark {
  std::string row;  // "LINKPOINTS 7"
  bool refused = false;
  std::string why;
};

struct MapManagerContent {
  std::vector<MapManagerMap> maps;  // by id
  std::vector<MapManagerPlace> places;
  std::vector<MapManagerRemark> remarks;
};

// Reads the file and the point clouds beside it. A row that is broken gives a remark and does not affect the others.
// NOT_FOUND: no such file; DATA_LOSS: not an SQLite file; INVALID_ARGUMENT: a table is missing.
absl::StatusOr<MapManagerContent> ReadMapManagerDatabase(const std::string& path);

}  // namespace enfilade::sources
