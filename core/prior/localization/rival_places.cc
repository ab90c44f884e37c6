// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/rival_places.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/grid/log_odds_grid.h"
#include "core/prior/alignment/judged_places.h"
#include "core/prior/correction/correct_plan.h"

namespace enfilade::prior {
namespace {

constexpr double kHistory = 40;       // m of the drive that the map is made of
constexpr double kCell = 0.05;        // m, of the map
constexpr double kShown = 3.0;        // m: how wrong a plan may be around a point that people have shown
constexpr double kWithin = 1.5;       // m: how far a place may be from where the plan lies
constexpr double kComparable = 1.5;   // places that fit so many times worse explain nothing
constexpr double kLeastMass = 0.002;  // of a mode
constexpr std::size_t kMostModes = 6;
constexpr std::size_t kMostJudged = 10;

// From the plan frame to the sheet.
Eigen::Matrix2d SheetOf(const PlanField& field) {
  return Eigen::Vector2d(1, -1).asDiagonal().toDenseMatrix() / field.metres_per_unit();
}

// Of a plan whose scale is as wrong as particles may have it.
AlignOptions AlignOptionsOf(const PlanField& field, const PlanLocalizerOptions& options, const KeepGoing& keep_going) {
  AlignOptions aligning;
  aligning.log_evidence = &LogEvidenceOf;
  aligning.known_scales = {field.metres_per_unit() * std::exp(-options.scale_spread),
                           field.metres_per_unit() * std::exp(options.scale_spread)};
  if (keep_going) aligning.is_stopped = [keep_going] { return !keep_going().ok(); };
  return aligning;
}

}  // namespace

PlanTransform PlaceOf(const PlanField& field, const PlanState& state, const Pose2& T_map_robot) {
  const Pose2 T_robot_map = Inverse(T_map_robot);
  const Eigen::Matrix2d plan_robot = LinearOf(state, field.axis());
  const Eigen::Matrix2d sheet_map =
      SheetOf(field) * plan_robot * Eigen::Rotation2Dd(T_robot_map.yaw).toRotationMatrix();
  const Eigen::Vector2d origin = SheetOf(field) * (state.translation() + plan_robot * T_robot_map.translation());
  PlanTransform place;
  place.linear = sheet_map.inverse();
  place.offset = -place.linear * origin;
  return place;
}

PlanState StateAt(const PlanField& field, const PlanTransform& T_map_sheet, const Pose2& T_map_robot) {
  const Eigen::Vector2d at = field.ToPlan(ToSheet(T_map_sheet, T_map_robot.translation()));
  PlanState state{.x = at.x(), .y = at.y(), .mirrored = T_map_sheet.mirrored()};
  const Eigen::Matrix2d axes = Eigen::Rotation2Dd(field.axis()).toRotationMatrix();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(T_map_robot.yaw).toRotationMatrix();
  // Along the plan's axes: each row is one's scale times a direction (LinearOf).
  Eigen::Matrix2d along = axes.transpose() * SheetOf(field).inverse() * T_map_sheet.linear.inverse() * turn;
  if (state.mirrored) along.col(1) = -along.col(1);
  const double first = -std::log(along.row(0).norm());
  const double second = -std::log(along.row(1).norm());
  state.log_scale = 0.5 * (first + second);
  state.log_stretch = 0.5 * (first - second);
  along.rowwise().normalize();
  state.yaw = WrapAngle(field.axis() + std::atan2(along(1, 0) - along(0, 1), along(0, 0) + along(1, 1)));
  return state;
}

RivalPlaces::RivalPlaces(const PlanField& field, const std::vector<ControlPair>& pairs,
                         const PlanLocalizerOptions& options, const KeepGoing& keep_going)
    : field_(field), pairs_(pairs), aligning_(AlignOptionsOf(field, options, keep_going)) {}

void RivalPlaces::Add(const PlanLook& look, double travelled) {
  seen_.push_back({travelled, look});
  while (seen_.front().travelled < travelled - kHistory) seen_.pop_front();
}

void RivalPlaces::Remember(const std::vector<PlanMode>& found, const Pose2& T_map_robot) {
  found_.clear();
  for (std::size_t i = 0; i < std::min(found.size(), kMostModes); ++i) {
    found_.push_back(PlaceOf(field_, found[i].mean, T_map_robot));
  }
}

MapEvidence RivalPlaces::Evidence() const {
  grid::LogOddsGrid map(kCell, {});
  for (const Seen& seen : seen_) {
    grid::ScanRays rays;
    rays.origin = seen.look.T_map_robot.translation();
    for (const Eigen::Vector2d& hit : seen.look.hits) rays.hits.push_back(seen.look.T_map_robot * hit);
    // One that would make the map too large is left out.
    map.Insert(rays).IgnoreError();
  }
  return EvidenceOf(map.ToOccupancyGrid());
}

bool RivalPlaces::IsShown(const PlanTransform& place) const {
  return std::all_of(pairs_.begin(), pairs_.end(), [&](const ControlPair& pair) {
    return (place(pair.point_sheet) - pair.point_map).norm() <= kShown;
  });
}

// Other modes, what the last search found, and what was likely the last time.
std::vector<PlanTransform> RivalPlaces::KnownRivals(const std::vector<PlanMode>& modes,
                                                    const Pose2& T_map_robot) const {
  std::vector<PlanTransform> rivals = judged_;
  rivals.insert(rivals.end(), found_.begin(), found_.end());
  for (std::size_t i = 1; i < std::min(modes.size(), kMostModes); ++i) {
    if (modes[i].mass >= kLeastMass) rivals.push_back(PlaceOf(field_, modes[i].mean, T_map_robot));
  }
  return rivals;
}

// The mode's own place and the rivals that explain comparably, the likeliest first.
std::vector<JudgedPlace> RivalPlaces::Judged(const Candidate& own, std::vector<Candidate> rivals,
                                             const Aligner& aligner, const MapEvidence& evidence) const {
  std::stable_sort(rivals.begin(), rivals.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  std::vector<Candidate> places{own};
  for (const Candidate& rival : rivals) {
    if (places.size() == kMostJudged || kComparable * rival.score < own.score) break;
    if (!IsShown(rival.transform)) continue;
    const bool is_new = std::none_of(places.begin(), places.end(), [&](const Candidate& place) {
      return aligner.IsSamePlace(place.transform, rival.transform);
    });
    if (is_new) places.push_back(rival);
  }
  return JudgedByEvidence(field_.plan(), evidence, places, aligning_);
}

PlaceVerdict RivalPlaces::Compare(const std::vector<PlanMode>& modes, const Pose2& T_map_robot, bool everywhere) {
  const MapEvidence evidence = Evidence();
  if (evidence.walls.empty()) return {};
  const Aligner aligner(field_.plan(), evidence, aligning_);
  const auto refined = [&](const PlanTransform& start) {
    return aligner.RefinedFrom({.transform = start, .agreement = {}}, kWithin);
  };
  const Candidate own = refined(PlaceOf(field_, modes.front().mean, T_map_robot));
  std::vector<Candidate> rivals;
  for (const PlanTransform& known : KnownRivals(modes, T_map_robot)) {
    if (IsStopped(aligning_)) return {};
    rivals.push_back(refined(known));
  }
  std::vector<Candidate> twins = aligner.Ranked({own});
  rivals.insert(rivals.end(), twins.begin(), twins.end());
  std::vector<JudgedPlace> judged = Judged(own, rivals, aligner, evidence);
  const auto is_ruled_out = [&](const JudgedPlace& other) {
    return judged.front().evidence - other.evidence >=
           NeededEvidence(judged.front().place.transform, other.place.transform, aligning_);
  };
  const auto is_proven = [&] { return std::all_of(judged.begin() + 1, judged.end(), is_ruled_out); };
  if (everywhere && is_proven()) {
    for (const Stretch stretch : {Stretch::kNone, Stretch::kAlongWalls}) {
      if (IsStopped(aligning_)) return {};
      const std::vector<Candidate> others = aligner.Finalists(stretch);
      rivals.insert(rivals.end(), others.begin(), others.end());
    }
    judged = Judged(own, std::move(rivals), aligner, evidence);
  }
  if (IsStopped(aligning_)) return {};
  judged_.clear();
  for (const JudgedPlace& one : judged) judged_.push_back(one.place.transform);
  PlaceVerdict verdict;
  if (is_proven()) verdict.proven = judged_.front();
  const auto asked = std::find_if(judged.begin(), judged.end(), [&](const JudgedPlace& one) {
    return one.place.transform.linear == own.transform.linear && one.place.transform.offset == own.transform.offset;
  });
  if (asked == judged.begin() || !is_ruled_out(*asked)) return verdict;
  for (const JudgedPlace& one : judged) {
    if (!is_ruled_out(one)) verdict.likelier.push_back(one.place.transform);
  }
  return verdict;
}

}  // namespace enfilade::prior
