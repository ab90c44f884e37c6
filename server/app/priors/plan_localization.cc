// SPDX-License-Identifier: Apache-2.0
#include "server/app/priors/plan_localization.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/prior/localization/drive_scans.h"
#include "core/prior/localization/mode_in_map.h"
#include "core/prior/localization/plan_start.h"
#include "fmt/format.h"
#include "server/app/localization/call_progress.h"
#include "server/app/priors/stored_plan.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kScansAtOnce = 100;  // read from the log

// With pairs the robot is placed at once; else it is looked for when it has driven so far.
double LeastDistance(const PlanLocalizationQuery& query) {
  return query.pairs.empty() ? prior::PlanLocalizerOptions().global_distance : 0;
}

// In the frame of the robot's own map, in which its first scan was taken at 0, 0, 0.
std::vector<prior::ControlPair> PairsInMap(const PlanLocalizationQuery& query, const prior::PlanGraph& plan) {
  std::vector<prior::ControlPair> pairs = query.pairs;
  const Pose2 T_map_given = query.session ? Pose2{} : Inverse(*query.scans.front().T_odom_robot);
  for (prior::ControlPair& pair : pairs) {
    pair.point_sheet = prior::ToSheet(plan, pair.point_sheet);
    pair.point_map = T_map_given * pair.point_map;
  }
  return pairs;
}

// Two pairs and more say the scale; what is wrong with it otherwise is the plan's fault.
absl::StatusOr<double> ScaleOf(const storage::PriorMap& prior_map, const prior::PlanGraph& plan,
                               const std::vector<prior::ControlPair>& pairs) {
  absl::StatusOr<double> scale = prior::NominalScale(plan, pairs);
  if (scale.ok() || pairs.size() >= 2 || !absl::IsInvalidArgument(scale.status())) return scale;
  return FailedPrecondition("{}: {}", NameOf(prior_map.site, prior_map.id), std::string(scale.status().message()));
}

std::string ReasonOf(const prior::PlanPosterior& last, const prior::PlanLocalizerOptions& options) {
  if (last.modes.empty()) {
    return fmt::format("the robot has not driven far enough: {:.1f} m, {:.0f} m are needed", last.travelled,
                       options.global_distance);
  }
  const prior::PlanMode& best = last.modes.front();
  const double width = std::sqrt(
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(best.covariance.topLeftCorner<2, 2>()).eigenvalues().y());
  const std::string seen =
      fmt::format("{:.0f} % of what was seen lately lies on walls of the plan there", 100 * last.matched);
  if (last.confident) {
    return fmt::format("one place has {:.0f} % of the mass and is known to {:.2f} m; {}", 100 * best.mass, width, seen);
  }
  if (best.mass < options.confident_mass) {
    return fmt::format("{} places are possible: the heaviest has {:.0f} % of the mass, {:.0f} % are needed",
                       last.modes.size(), 100 * best.mass, 100 * options.confident_mass);
  }
  if (last.matched < options.confident_match) {
    return fmt::format("only {}, {:.0f} % are needed", seen, 100 * options.confident_match);
  }
  if (width > options.confident_sigma) {
    return fmt::format("the place is known to {:.1f} m in one direction, as in a corridor: {:.1f} m are needed", width,
                       options.confident_sigma);
  }
  if (!last.proven) {
    return fmt::format("one place has {:.0f} % of the mass, but others are not ruled out yet: drive on",
                       100 * best.mass);
  }
  return fmt::format("one place has {:.0f} % of the mass, but has not held for long enough: drive on", 100 * best.mass);
}

bool IsPlaced(const storage::PriorMap& prior_map) {
  return prior_map.alignment.has_value() &&
         (prior_map.state == storage::PriorMapState::kActive || prior_map.state == storage::PriorMapState::kProposed);
}

// `motion`: of the robot since the drive's last look.
std::vector<RobotInPlan> RobotsAt(const storage::PriorMap& prior_map, const prior::PlanField& field,
                                  const std::vector<prior::PlanMode>& modes, const Pose2& motion) {
  std::vector<RobotInPlan> robots;
  for (std::size_t i = 0; i < std::min(modes.size(), PlanLocalization::kMostModes); ++i) {
    RobotInPlan& robot = robots.emplace_back();
    robot.mode = modes[i];
    robot.mode.mean = prior::Moved(robot.mode.mean, motion, field.axis());
    robot.point_sheet = field.ToSheet(robot.mode.mean.translation());
    robot.metres_per_unit = field.metres_per_unit() * std::exp(robot.mode.mean.log_scale);
    if (!IsPlaced(prior_map)) continue;
    robot.T_world_robot = prior::InMap(field, robot.mode, prior_map.alignment->T_world_sheet);
  }
  return robots;
}

double TravelledOver(const std::vector<prior::DriveLook>& looks) {
  double travelled = 0;
  for (std::size_t i = 1; i < looks.size(); ++i) {
    travelled += Between(looks[i - 1].look.T_map_robot, looks[i].look.T_map_robot).translation().norm();
  }
  return travelled;
}

// `steps`: at least one.
PlanLocalizationAnswer AnswerOf(const std::vector<prior::PlanPosterior>& steps,
                                const prior::PlanLocalizerOptions& options) {
  const prior::PlanPosterior& last = steps.back();
  PlanLocalizationAnswer answer;
  answer.confident = last.confident;
  answer.reason = ReasonOf(last, options);
  answer.travelled = last.travelled;
  answer.matched = last.matched;
  answer.keyframes = static_cast<int>(steps.size());
  const auto first = std::find_if(steps.begin(), steps.end(), [](const auto& step) { return step.confident; });
  if (first != steps.end()) answer.confident_after = first->travelled;
  return answer;
}

}  // namespace

// The keyframes whose scans are still stored, with these.
absl::StatusOr<prior::MappedDrive> PlanLocalization::ReadLooks(const storage::CallContext& context, const SiteId& site,
                                                               const SessionId& session,
                                                               const std::vector<slam::SlamNode>& nodes) const {
  prior::MappedDrive drive;
  for (std::size_t begin = 0; begin < nodes.size(); begin += kScansAtOnce) {
    ENFILADE_RETURN_IF_ERROR(CheckProgress(context));
    std::map<std::int64_t, const slam::SlamNode*> by_sequence;
    std::vector<std::int64_t> sequences;
    for (std::size_t i = begin; i < std::min(nodes.size(), begin + kScansAtOnce); ++i) {
      by_sequence[nodes[i].sequence] = &nodes[i];
      sequences.push_back(nodes[i].sequence);
    }
    ENFILADE_ASSIGN_OR_RETURN(const auto records, stores_.records.ReadEach(context, site, session, sequences));
    for (const sensor::Record& record : records) {
      const auto* scan = std::get_if<sensor::LaserScan>(&record.payload);
      if (scan != nullptr) prior::AddLook(*by_sequence.at(record.sequence), *scan, slam_, drive);
    }
  }
  return drive;
}

absl::StatusOr<prior::MappedScans> PlanLocalization::ReadSession(const storage::CallContext& context,
                                                                 const SiteId& site, const SessionId& session,
                                                                 double least_distance) const {
  ENFILADE_RETURN_IF_ERROR(stores_.sessions.Get(context, site, session).status());
  ENFILADE_ASSIGN_OR_RETURN(auto stored, stores_.mappings.Load(context, site, session));
  std::vector<slam::SlamNode> nodes;
  if (stored) {
    for (const auto& [id, node] : stored->map.nodes) nodes.push_back(node);
  }
  if (nodes.empty()) return FailedPrecondition("{} is not mapped: it has no keyframes", NameOf(site, session));
  if (nodes.size() > kMostKeyframes) nodes.erase(nodes.begin(), nodes.end() - kMostKeyframes);
  prior::MappedScans read{{}, nodes.back().T_map_node};
  ENFILADE_ASSIGN_OR_RETURN(read.drive, ReadLooks(context, site, session, nodes));
  const std::vector<prior::DriveLook>& looks = read.drive.looks;
  if (looks.empty()) {
    return FailedPrecondition("{}: the scans of its keyframes are deleted", NameOf(site, session));
  }
  if (const double travelled = TravelledOver(looks); travelled < least_distance) {
    return FailedPrecondition("{}: the robot drove {:.1f} m over its keyframes: {:.0f} m are needed",
                              NameOf(site, session), travelled, least_distance);
  }
  std::erase_if(stored->map.submaps, [&](const auto& submap) {
    return std::none_of(looks.begin(), looks.end(), [&](const auto& look) { return look.submap == submap.first; });
  });
  ENFILADE_ASSIGN_OR_RETURN(read.drive.submaps, prior::SubmapsOf(stored->map, slam_));
  return read;
}

absl::StatusOr<prior::MappedScans> PlanLocalization::MapDriveOf(const storage::CallContext& context, const SiteId& site,
                                                                const PlanLocalizationQuery& query) const {
  if (query.session) return ReadSession(context, site, *query.session, LeastDistance(query));
  return prior::MapScans(query.scans, slam_, [&] { return CheckProgress(context); });
}

absl::StatusOr<PlanLocalizationAnswer> PlanLocalization::Locate(const storage::CallContext& context,
                                                                const storage::PriorMap& prior_map,
                                                                const PlanLocalizationQuery& query) const {
  if (!query.session) {
    ENFILADE_RETURN_IF_ERROR(prior::CheckDriveScans(query.scans, {.least_distance = LeastDistance(query)}));
  }
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanGraph plan,
                            ReadStoredPlan(context, stores_.prior_maps, stores_.blobs, prior_map));
  const std::vector<prior::ControlPair> pairs = PairsInMap(query, plan);
  ENFILADE_ASSIGN_OR_RETURN(const double metres_per_unit, ScaleOf(prior_map, plan, pairs));
  const prior::PlanField field(plan, metres_per_unit);
  ENFILADE_ASSIGN_OR_RETURN(const prior::MappedScans mapped, MapDriveOf(context, prior_map.site, query));
  const prior::PlanLocalizerOptions options;
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanDrive drive, prior::LocateDrive(field, pairs, mapped.drive, options,
                                                                             [&] { return CheckProgress(context); }));
  PlanLocalizationAnswer answer = AnswerOf(drive.steps, options);
  // The last scan is not always a keyframe.
  const Pose2 motion = Between(mapped.drive.looks.back().look.T_map_robot, mapped.T_map_robot);
  answer.modes = RobotsAt(prior_map, field, drive.steps.back().modes, motion);
  answer.metres_per_unit = metres_per_unit;
  answer.axis = field.axis() + 0.0;  // JSON has no negative zero
  if (IsPlaced(prior_map)) answer.graph_version = prior_map.alignment->graph_version;
  return answer;
}

}  // namespace enfilade::server
