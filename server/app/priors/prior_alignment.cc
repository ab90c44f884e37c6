// SPDX-License-Identifier: Apache-2.0
#include "server/app/priors/prior_alignment.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/plans/plan_ties.h"
#include "core/prior/fit/fit_plan.h"
#include "core/prior/fit/join_maps.h"
#include "core/prior/products/products.h"
#include "core/prior/ties/find_ties.h"
#include "server/app/edits/edited_revision.h"
#include "server/app/mapping/raster_revision.h"
#include "server/app/priors/level_apart.h"
#include "server/app/priors/plans_beside.h"
#include "server/app/priors/stored_plan.h"

namespace enfilade::server {
namespace {

constexpr double kLevelCell = 0.05;  // m
constexpr int kMapsPage = 1000;

// Maps that no link points join to the root are looked for in the plan one by one, each for seconds: those with the
// most walls.
constexpr std::size_t kMostUnjoined = 16;
constexpr double kLeastWalls = 20.0;  // m, of such a map

// The graph without its plans, and without the link points that only a plan's door has made: they must not confirm what
// they have made.
absl::StatusOr<graph::WorldPoses> WithoutPlans(const graph::GraphSnapshot& graph,
                                               const std::vector<storage::PlanJoin>& joins) {
  graph::SnapshotChanges changes{.version = graph.version(), .plans = std::vector<graph::PlanInGraph>()};
  for (const storage::PlanJoin& join : joins) {
    if (!join.undone && !join.passed) changes.removed_link_points.push_back(join.link_point);
  }
  ENFILADE_ASSIGN_OR_RETURN(graph::GraphSnapshot without, graph::Apply(graph, changes));
  ENFILADE_ASSIGN_OR_RETURN(graph::SolvedGraph solution, graph::OptimizeGraph(without));
  changes.solution = std::make_shared<const graph::SolvedGraph>(std::move(solution));
  ENFILADE_ASSIGN_OR_RETURN(without, graph::Apply(without, changes));
  return graph::WorldPoses(std::move(without));
}

absl::StatusOr<std::vector<prior::ControlPair>> InWorld(const std::vector<storage::PriorMapPair>& pairs,
                                                        const LevelMaps& level) {
  const std::vector<LevelMap>& maps = level.maps;
  std::vector<prior::ControlPair> in_world;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const storage::PriorMapPair& pair = pairs[i];
    Eigen::Vector2d point = pair.point_map;
    if (pair.map.empty() && level.is_apart) {
      return InvalidArgument(
          "pairs[{}].map: expected a map, because none of the plan's level is joined to the root map", i);
    }
    if (!pair.map.empty()) {
      const auto map = std::find_if(maps.begin(), maps.end(), [&](const LevelMap& one) { return one.id == pair.map; });
      if (map == maps.end()) {
        return InvalidArgument(
            "pairs[{}].map is \"{}\": expected a map of the plan's level that has walls and is joined to the root map",
            i, pair.map.value());
      }
      point = map->T_world_map * point;
    }
    in_world.push_back({pair.point_sheet, point});
  }
  return in_world;
}

// The maps as one, in the world frame.
absl::StatusOr<grid::OccupancyGrid> Joined(const std::vector<LevelMap>& maps) {
  std::vector<prior::PlacedMap> placed;
  for (const LevelMap& map : maps) placed.push_back({&map.grid, &map.evidence, map.T_world_map});
  return prior::Overlaid(placed);
}

// How the map that has seen most of a plan has moved in the world since the plan was aligned; of a map that is not
// among `maps` that is not known.
Pose2 MovedSince(const graph::PlanTies& ties, const std::vector<LevelMap>& maps) {
  Pose2 T_now_then;
  std::ptrdiff_t most = 0;
  for (const graph::MapInPlan& then : ties.maps) {
    const auto now = std::find_if(maps.begin(), maps.end(), [&](const LevelMap& map) { return map.id == then.map; });
    const auto seen = std::count_if(ties.sightings.begin(), ties.sightings.end(),
                                    [&](const graph::WallSighting& sighting) { return sighting.map == then.map; });
    if (now == maps.end() || seen <= most) continue;
    most = seen;
    T_now_then = now->T_world_map * Inverse(then.T_plan_map);
  }
  return T_now_then;
}

void AddFiles(storage::PriorMapProduct product, std::vector<grid::MapFile> files,
              std::vector<storage::NewPriorMapFile>& out) {
  for (grid::MapFile& file : files) out.push_back({product, std::move(file.name), std::move(file.bytes)});
}

absl::StatusOr<std::vector<storage::NewPriorMapFile>> ProductsOf(const prior::PlanGraph& plan,
                                                                 const prior::PlanFit& fit) {
  std::vector<storage::NewPriorMapFile> files;
  AddFiles(storage::PriorMapProduct::kCorrected, prior::CorrectedFiles(plan, fit), files);
  ENFILADE_ASSIGN_OR_RETURN(std::vector<grid::MapFile> planning,
                            prior::PlanningFiles(plan, fit, grid::MapFileFormat::kPng));
  AddFiles(storage::PriorMapProduct::kPlanning, std::move(planning), files);
  ENFILADE_ASSIGN_OR_RETURN(grid::MapFile picture, prior::PictureFile(plan, fit));
  AddFiles(storage::PriorMapProduct::kPicture, {std::move(picture)}, files);
  return files;
}

}  // namespace

absl::StatusOr<grid::MapRaster> PriorAlignment::ReadRaster(const storage::CallContext& context,
                                                           const storage::Map& map) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision,
                            revisions_.Get(context, map.site, map.id, map.current_revision));
  return ReadEvidence(context, {blobs_, revisions_}, revision);
}

absl::StatusOr<LevelMaps> PriorAlignment::ReadLevel(const storage::CallContext& context,
                                                    const storage::PriorMap& prior_map) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, graphs_.Get(context, prior_map.site));
  LevelMaps level{.graph = graph};
  for (const graph::PlanInGraph& plan : graph->graph().plans()) {
    if (plan.id == prior_map.id) level.ties = plan.ties;
  }
  std::optional<graph::WorldPoses> without_plans;
  if (!graph->graph().plans().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const auto joins, plan_joins_.List(context, prior_map.site));
    ENFILADE_ASSIGN_OR_RETURN(graph::WorldPoses made, WithoutPlans(graph->graph(), joins));
    without_plans.emplace(std::move(made));
  }
  const graph::WorldPoses& poses = without_plans ? *without_plans : graph->poses;
  for (std::string after;;) {
    ENFILADE_ASSIGN_OR_RETURN(const auto page, maps_.List(context, prior_map.site, {kMapsPage, after}));
    for (const storage::Map& map : page) {
      if (map.level != prior_map.level || map.current_revision == 0) continue;
      const auto place = poses.Find(map.id);
      if (!place.ok()) continue;  // it was made after this version
      absl::StatusOr<grid::MapRaster> raster = ReadRaster(context, map);
      if (absl::IsNotFound(raster.status())) continue;  // it has been deleted meanwhile, and perhaps made again
      ENFILADE_RETURN_IF_ERROR(raster.status());
      ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid grid, OnMapLattice(*raster, kLevelCell));
      prior::MapEvidence evidence = prior::EvidenceOf(grid);
      if (*place && !evidence.walls.empty()) {
        level.maps.push_back(
            {map.id, (*place)->T_world_robot.pose, std::move(grid), std::move(evidence), map.create_time});
      } else if (!evidence.walls.empty()) {
        level.unjoined.push_back({map.id, {}, std::move(grid), std::move(evidence), map.create_time});
      }
    }
    if (page.size() < kMapsPage) break;
    after = page.back().id.value();
  }
  std::stable_sort(level.unjoined.begin(), level.unjoined.end(), [](const LevelMap& a, const LevelMap& b) {
    return a.evidence.walls.size() > b.evidence.walls.size();
  });
  if (level.maps.empty()) {
    ENFILADE_RETURN_IF_ERROR(LayOutApart(poses.graph(), level));
    ENFILADE_ASSIGN_OR_RETURN(const prior::PlanGraph plan, ReadStoredPlan(context, prior_maps_, blobs_, prior_map));
    ENFILADE_RETURN_IF_ERROR(CheckShafts(plan, prior_map, level));
    if (level.ties == nullptr && prior_map.alignment) {
      ENFILADE_ASSIGN_OR_RETURN(const auto ties, ReadTies(context, prior_maps_, blobs_, prior_map.site, prior_map.id));
      if (ties) level.ties = std::make_shared<const graph::PlanTies>(*ties);
    }
  }
  std::erase_if(level.unjoined, [](const LevelMap& map) { return map.evidence.wall_length() < kLeastWalls; });
  if (level.unjoined.size() > kMostUnjoined) level.unjoined.resize(kMostUnjoined);
  return level;
}

absl::StatusOr<AlignedPriorMap> PriorAlignment::Align(const storage::CallContext& context,
                                                      const storage::PriorMap& prior_map,
                                                      const std::vector<storage::PriorMapPair>& pairs, bool from_last,
                                                      bool activate) const {
  ENFILADE_ASSIGN_OR_RETURN(LevelMaps level, ReadLevel(context, prior_map));
  Placement placement{.options = {},
                      .accepted_state = activate ? storage::PriorMapState::kActive : storage::PriorMapState::kProposed};
  ENFILADE_ASSIGN_OR_RETURN(placement.options.pairs, InWorld(pairs, level));
  if (from_last) placement.options.start = PlaceNow(prior_map, level);
  ENFILADE_ASSIGN_OR_RETURN(AlignedPriorMap aligned, Fit(context, prior_map, std::move(level), placement));
  if (aligned.outcome.alignment) aligned.outcome.alignment->pairs = from_last ? prior_map.alignment->pairs : pairs;
  return aligned;
}

absl::StatusOr<AlignedPriorMap> PriorAlignment::AlignAgain(const storage::CallContext& context,
                                                           const storage::PriorMap& prior_map) const {
  if (!prior_map.alignment) return FailedPrecondition("{} was never aligned", NameOf(prior_map.site, prior_map.id));
  ENFILADE_ASSIGN_OR_RETURN(LevelMaps level, ReadLevel(context, prior_map));
  Placement placement{.options = {}, .accepted_state = prior_map.state};
  placement.options.start = PlaceNow(prior_map, level);
  ENFILADE_ASSIGN_OR_RETURN(AlignedPriorMap aligned, Fit(context, prior_map, std::move(level), placement));
  if (aligned.outcome.alignment) {
    aligned.outcome.alignment->pairs = prior_map.alignment->pairs;
    aligned.outcome.alignment->rival_ratio = prior_map.alignment->rival_ratio;
    if (aligned.outcome.state == prior_map.state) aligned.outcome.reason = prior_map.reason;
  } else {
    aligned.outcome.reason = "robots have seen more, and it does not fit that: " + aligned.outcome.reason;
  }
  return aligned;
}

prior::PlanTransform PriorAlignment::PlaceNow(const storage::PriorMap& prior_map, const LevelMaps& level) {
  const Pose2 T_now_then = level.ties == nullptr ? Pose2{} : MovedSince(*level.ties, level.maps);
  return T_now_then * prior_map.alignment.value().T_world_sheet;
}

absl::StatusOr<AlignedPriorMap> PriorAlignment::Fit(const storage::CallContext& context,
                                                    const storage::PriorMap& prior_map, LevelMaps level,
                                                    const Placement& placement) const {
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanGraph plan, ReadStoredPlan(context, prior_maps_, blobs_, prior_map));
  prior::FitOptions options = placement.options;
  options.threads = threads_;
  for (prior::ControlPair& pair : options.pairs) pair.point_sheet = prior::ToSheet(plan, pair.point_sheet);
  AlignedPriorMap aligned;
  std::vector<prior::ControlPair> pairs = options.pairs;  // in the world
  std::optional<ApartLevelPlace> apart;
  if (level.is_apart) {
    ENFILADE_ASSIGN_OR_RETURN(apart, PlaceApartLevel(plan, prior_map, level, options));
    aligned.outcome.reason = apart->reason;
    if (!apart->T_world_level) return aligned;
    const Pose2& T_world_level = *apart->T_world_level;
    for (LevelMap& map : level.maps) map.T_world_map = T_world_level * map.T_world_map;
    for (prior::ControlPair& pair : pairs) pair.point_map = T_world_level * pair.point_map;
    options.pairs.clear();
    options.start = T_world_level * apart->T_level_sheet;
  }
  ENFILADE_ASSIGN_OR_RETURN(grid::OccupancyGrid joined, Joined(level.maps));
  std::vector<grid::OccupancyGrid> grids;
  grids.push_back(std::move(joined));
  for (const LevelMap& map : level.unjoined) grids.push_back(map.grid);
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanFit fit, prior::FitPlan(plan, grids, options));

  aligned.outcome.reason = apart && fit.alignment.accepted ? apart->reason : fit.alignment.reason;
  if (!fit.alignment.accepted) return aligned;
  std::vector<prior::MapOfPlan> maps;
  for (const LevelMap& map : level.maps) maps.push_back({map.id, &map.evidence, map.T_world_map});
  for (std::size_t i = 0; i < level.unjoined.size(); ++i) {
    const std::optional<Pose2>& T_world_map = fit.maps[i + 1].T_first_map;
    if (T_world_map) maps.push_back({level.unjoined[i].id, &level.unjoined[i].evidence, *T_world_map});
  }
  const graph::PlanTies ties = prior::FindTies(plan, fit.alignment.T_map_sheet, *fit.corrected, maps);
  if (!apart) {
    ENFILADE_ASSIGN_OR_RETURN(std::string objection, ObjectionOfShafts(level.graph->graph(), prior_map, ties));
    if (!objection.empty()) {
      aligned.outcome.reason = std::move(objection);
      return aligned;
    }
  }
  aligned.outcome.state = placement.accepted_state;
  storage::PriorMapAlignment& alignment = aligned.outcome.alignment.emplace();
  alignment.T_world_sheet = fit.alignment.T_map_sheet;
  alignment.model = fit.alignment.model;
  alignment.explained = fit.corrected->agreement().explained;
  alignment.contradicted = fit.corrected->agreement().contradicted();
  alignment.rival_ratio = apart ? apart->rival_ratio : fit.alignment.rival_ratio;
  std::vector<TimeNs>& create_times = aligned.outcome.map_create_times.emplace();
  for (const LevelMap& map : level.maps) {
    create_times.push_back(map.create_time);
    if (level.is_apart) alignment.joined_maps.push_back(map.id);
  }
  for (std::size_t i = 0; i < level.unjoined.size(); ++i) {
    if (!fit.maps[i + 1].T_first_map) continue;
    create_times.push_back(level.unjoined[i].create_time);
    alignment.joined_maps.push_back(level.unjoined[i].id);
  }
  for (const prior::MapOfPlan& map : maps) alignment.maps.push_back(map.id);
  alignment.tied_walls = static_cast<int>(ties.sightings.size());
  alignment.graph_version = level.graph->graph().version();
  for (const prior::ControlPair& pair : pairs) {
    aligned.pair_residuals.push_back((fit.corrected->Locate(pair.point_sheet).point - pair.point_map).norm());
  }
  const bool is_put_to_use =
      placement.accepted_state == storage::PriorMapState::kActive && prior_map.state != storage::PriorMapState::kActive;
  if (is_put_to_use) {
    ENFILADE_ASSIGN_OR_RETURN(PlansBeside beside, FindPlansBeside(context, prior_maps_, blobs_, prior_map, ties));
    if (beside.same_area) {
      aligned.outcome.state = storage::PriorMapState::kProposed;
      aligned.outcome.reason +=
          fmt::format("; not in use, because {} is and has the same walls", NameOf(prior_map.site, *beside.same_area));
    }
    aligned.outcome.beside = std::move(beside.etags);
  }
  ENFILADE_ASSIGN_OR_RETURN(aligned.outcome.files, ProductsOf(plan, fit));
  aligned.outcome.files.push_back({storage::PriorMapProduct::kTies, "ties.bin", graph::EncodePlanTies(ties)});
  return aligned;
}

}  // namespace enfilade::server
