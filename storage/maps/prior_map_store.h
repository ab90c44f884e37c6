// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/prior/alignment/plan_transform.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// The numbers are those of the database.
enum class PriorMapState {
  kNew = 1,
  kProposed = 2,
  kActive = 3,
  kDiverged = 4,
  kSuspended = 5,
};

// What was found in the file, and corrected by people.
struct PriorMapElements {
  int walls = 0;
  int corners = 0;
  int doors = 0;
  int rooms = 0;
  int shafts = 0;
  std::optional<double> metres_per_unit = std::nullopt;
};

// The same point on the sheet and in a map, as a person has shown it.
struct PriorMapPair {
  Eigen::Vector2d point_sheet = Eigen::Vector2d::Zero();
  MapId map;                                            // empty: the world frame
  Eigen::Vector2d point_map = Eigen::Vector2d::Zero();  // m
};

struct PriorMapAlignment {
  prior::PlanTransform T_world_sheet;
  prior::TransformModel model = prior::TransformModel::kSimilarity;
  double explained = 0;
  double contradicted = 0;
  double rival_ratio = 0;
  std::vector<MapId> maps;  // without those that were deleted since
  std::int64_t graph_version = 0;
  std::vector<PriorMapPair> pairs;
  int tied_walls = 0;              // how often a map has seen a wall of the plan
  std::vector<MapId> joined_maps;  // those of `maps` that no link points joined to the root map
  TimeNs time = 0;                 // set by the store
};

struct PriorMap {
  SiteId site;
  PriorMapId id;
  std::string display_name;  // 1 to 200 characters, unique in its site
  int level = 0;
  PriorMapState state = PriorMapState::kNew;
  std::string reason;
  std::string file_name;
  std::vector<std::string> warnings;
  PriorMapElements elements;
  std::optional<PriorMapAlignment> alignment;
  // Set by the store.
  std::int64_t etag = 0;
  TimeNs create_time = 0;
  TimeNs update_time = 0;
};

// The numbers are those of the database.
enum class PriorMapProduct {
  kSheet = 1,      // the imported file
  kPlan = 2,       // what was found in it, and corrected by people
  kCorrected = 3,  // the plan as it is built
  kPlanning = 4,
  kPicture = 5,
  kTies = 6,  // graph::PlanTies: what the site's graph has of it while it is in use
};

struct PriorMapFile {
  PriorMapProduct product = PriorMapProduct::kSheet;
  std::string name;
  std::int64_t size = 0;
  std::string sha256;  // of its blob
};

// A file with its bytes.
struct NewPriorMapFile {
  PriorMapProduct product = PriorMapProduct::kSheet;
  std::string name;
  std::string bytes;  // 1 byte to kMaxBlobBytes
};

// What becomes of a prior map when it is aligned.
struct PriorMapOutcome {
  PriorMapState state = PriorMapState::kDiverged;
  std::string reason;
  // Unset: the last one stays, with what was made by it.
  std::optional<PriorMapAlignment> alignment = std::nullopt;
  std::vector<NewPriorMapFile> files = {};  // of the alignment
  // When each map of the alignment was created. One that was deleted meanwhile, or made again, is left out of it.
  // Unset: not compared.
  std::optional<std::vector<TimeNs>> map_create_times = std::nullopt;
  // With kActive: the etags of all other prior maps of the level in use that may be so beside this one. Unset: any may.
  std::optional<std::vector<std::int64_t>> beside = std::nullopt;
};

// Prior maps with their files, whose blobs they keep. While one is in use (kActive) it ties maps together: what changes
// that, or changes its ties meanwhile, raises the version of the site's graph. Thread-safe; errors common to all
// stores: see SiteStore. A stale etag (0: any) is ABORTED.
class PriorMapStore {
 public:
  explicit PriorMapStore(postgres::Pool& pool) : pool_(pool) {}

  // With the files of the import. ALREADY_EXISTS naming whether the id or the display name is taken; NOT_FOUND if the
  // site does not exist.
  absl::StatusOr<PriorMap> Create(const CallContext& context, const PriorMap& prior_map,
                                  const std::vector<NewPriorMapFile>& files) const;
  // NOT_FOUND.
  absl::StatusOr<PriorMap> Get(const CallContext& context, const SiteId& site, const PriorMapId& id) const;
  // By id.
  absl::StatusOr<std::vector<PriorMap>> List(const CallContext& context, const SiteId& site,
                                             const PageRequest& page) const;
  // Prior maps in use, of all sites, that were aligned at least `age` ago and before a map of their level got its
  // present revision; those that were aligned first come first.
  absl::StatusOr<std::vector<PriorMap>> ListOutgrown(const CallContext& context, std::chrono::seconds age,
                                                     std::int64_t limit) const;
  // NOT_FOUND; ALREADY_EXISTS.
  absl::StatusOr<PriorMap> Rename(const CallContext& context, const SiteId& site, const PriorMapId& id,
                                  std::int64_t etag, const std::string& display_name) const;
  // NOT_FOUND. ABORTED, too, if a prior map of the level is in use that is not listed in `beside`.
  absl::StatusOr<PriorMap> SetOutcome(const CallContext& context, const SiteId& site, const PriorMapId& id,
                                      std::int64_t etag, const PriorMapOutcome& outcome) const;
  // The plan that people have corrected, as the file of its product kPlan. What the last alignment has made is deleted,
  // but for where it has placed the plan; the state becomes kNew. NOT_FOUND.
  absl::StatusOr<PriorMap> ReplacePlan(const CallContext& context, const SiteId& site, const PriorMapId& id,
                                       std::int64_t etag, const PriorMapElements& elements, const NewPriorMapFile& plan,
                                       const std::string& reason) const;
  // NOT_FOUND. FAILED_PRECONDITION, naming the maps that it ties, if it is in use and `force` is not set.
  absl::Status Delete(const CallContext& context, const SiteId& site, const PriorMapId& id, std::int64_t etag,
                      bool force) const;
  // By product and name; none if there is no such prior map.
  absl::StatusOr<std::vector<PriorMapFile>> ListFiles(const CallContext& context, const SiteId& site,
                                                      const PriorMapId& id) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
