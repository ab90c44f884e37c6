// SPDX-License-Identifier: Apache-2.0
#include "core/doors/gap_detector.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/doors/jamb_walls.h"
#include "core/doors/passage_evidence.h"
#include "fmt/format.h"

namespace enfilade::doors {
namespace {

using State = CriterionVerdict::State;

constexpr double kTangent = 0.4;       // m before and behind, for the path's direction
constexpr double kCrossing = 0.25;     // m around the place that is searched
constexpr double kMissingAhead = 0.5;  // m: kMissingInWall of a wall that is seen from one side only, in passing
constexpr double kBeside = 0.5;        // m before and behind a door: is there a way round between them?
constexpr double kLeftBehind = 3.5;    // m: a latched door farther away becomes a candidate immediately
constexpr double kForgotten = 7.0;     // m: narrow places farther away are forgotten

double CrossOf(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Whether the step from p to q crosses the line between the posts.
bool Crosses(const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Narrows& door) {
  const Eigen::Vector2d edge = door.right - door.left;
  const double before = CrossOf(edge, p - door.left);
  const double behind = CrossOf(edge, q - door.left);
  if ((before > 0.0) == (behind > 0.0)) return false;
  const Eigen::Vector2d at = p + (q - p) * (before / (before - behind));
  const double t = (at - door.left).dot(edge) / edge.squaredNorm();
  return t > 0.0 && t < 1.0;
}

// The middle between the posts, looking through the door as one does who goes along `way`.
Pose2 LookingThrough(const Narrows& door, const Eigen::Vector2d& way) {
  Eigen::Vector2d through((door.left - door.right).y(), -(door.left - door.right).x());
  if (through.dot(way) < 0.0) through = -through;
  return {door.middle().x(), door.middle().y(), std::atan2(through.y(), through.x())};
}

std::string SeenAhead(int scans, const Narrows& narrows) {
  return fmt::format("{} scans saw {:.2f} m between posts ahead", scans, narrows.width());
}

}  // namespace

GapDetector::GapDetector(const DoorOptions& options)
    : options_(options),
      map_(options.gap.cell, options.gap.reach),
      path_(2.0 * std::max(options.gap.lag, options.environment.settle) + 1.5) {}

void GapDetector::Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot, std::vector<DoorEvent>& events) {
  map_.Add(scan, T_odom_robot);
  path_.Add(scan, T_odom_robot);
  UpdateCrossings();
  SearchBehind(events);
  SearchAhead(events);
  ReportCandidates(false, events);
  ForgetDistantTracks();
}

void GapDetector::SearchAhead(std::vector<DoorEvent>& events) {
  const GapOptions& o = options_.gap;
  const Pose2& pose = path_.view().T_odom_robot;
  const TimeNs time = path_.view().time;
  const Eigen::Vector2d heading(std::cos(pose.yaw), std::sin(pose.yaw));
  const NarrowsSearch search =
      FindNarrows(map_, {.origin = pose.translation(), .direction = heading, .begin = 0.3, .end = o.look_ahead}, o);
  if (!search.narrows) return;
  const Narrows& found = *search.narrows;
  auto track = std::find_if(tracks_.begin(), tracks_.end(), [&](const DoorTrack& one) {
    return (one.narrows.middle() - found.middle()).norm() < o.same_place;
  });
  if (track == tracks_.end()) track = tracks_.insert(tracks_.end(), DoorTrack{});
  track->narrows = found;
  track->hits += 1;
  // Robots that scan rarely pass a door after two scans; these show as much as three close to each other.
  track->weight += path_.LastStep().length() >= o.sparse ? 2 : 1;
  track->last_hit = time;
  track->crossed_at = -1.0;
  if (track->weight < o.hits || track->door > 0 || !IsNewDoor(found)) return;
  track->door = ++doors_;
  track->latch_time = time;
  track->T_odom_latch = pose;
  DoorEvent event = CandidateOf(*track, DoorEvent::Kind::kLatched);
  event.reason = search.reason;
  events.push_back(std::move(event));
}

// Is there no way round it, and no other latched door beside it?
bool GapDetector::IsNewDoor(const Narrows& door) const {
  const Pose2& pose = path_.view().T_odom_robot;
  const Eigen::Vector2d heading(std::cos(pose.yaw), std::sin(pose.yaw));
  const Eigen::Vector2d beyond = door.middle() + kBeside * heading;
  if (map_.AreJoined(pose.translation(), beyond, {door.left, door.right}, {door.middle(), options_.gap.detour})) {
    return false;
  }
  return std::none_of(tracks_.begin(), tracks_.end(), [&](const DoorTrack& one) {
    return one.door > 0 && (one.narrows.middle() - door.middle()).norm() < options_.candidate_spacing;
  });
}

void GapDetector::UpdateCrossings() {
  const DrivenPath::Step step = path_.LastStep();
  for (DoorTrack& track : tracks_) {
    if (track.crossed_at < 0.0 && track.weight >= options_.gap.hits && Crosses(step.from, step.to, track.narrows)) {
      track.crossed_at = step.middle;
    }
  }
}

DoorTrack* GapDetector::FindTrack(const Narrows& door) {
  DoorTrack* found = nullptr;
  for (DoorTrack& one : tracks_) {
    const double distance = (one.narrows.middle() - door.middle()).norm();
    if (one.weight >= options_.gap.hits && distance < options_.gap.same_place) found = &one;
  }
  return found;
}

// The path's direction around a place on it, a unit vector; unset if that part is forgotten, or the robot turned there.
std::optional<Eigen::Vector2d> GapDetector::PathDirectionAt(double travelled) const {
  if (travelled - kTangent < path_.oldest_travelled()) return std::nullopt;
  const Eigen::Vector2d way = path_.PositionAt(travelled + kTangent) - path_.PositionAt(travelled - kTangent);
  if (way.norm() < kTangent) return std::nullopt;
  return way.normalized();
}

void GapDetector::SearchBehind(std::vector<DoorEvent>& events) {
  const GapOptions& o = options_.gap;
  GapOptions behind = o;
  behind.max_depth = std::max(o.max_depth, o.behind_depth);
  behind.repeated = std::max(o.repeated, o.behind_repeated);
  behind.widening = std::min(o.widening, o.behind_widening);
  // The path is searched piece by piece, each when the robot is `lag` beyond it.
  const double until = path_.travelled() - o.lag;
  for (; searched_ + kCrossing <= until; searched_ += kCrossing) {
    const double at = searched_ + kCrossing;
    const std::optional<Eigen::Vector2d> direction = PathDirectionAt(at);
    if (!direction) continue;
    const NarrowsSearch search = FindNarrows(
        map_, {.origin = path_.PositionAt(at), .direction = *direction, .begin = -kCrossing, .end = kCrossing}, behind);
    if (search.narrows && at + search.narrows->along - last_passage_ > o.spacing) {
      JudgeCrossing({*search.narrows, at + search.narrows->along, search.reason}, events);
    }
    for (DoorTrack& track : tracks_) {
      if (track.crossed_at < 0.0 || track.crossed_at + 2.0 * kCrossing > at) continue;
      track.hits = 0;  // done with
      track.weight = 0;
      track.crossed_at = -1.0;
      track.reported = true;  // the robot went through: it is a passage, or no door
    }
  }
}

CriterionVerdict GapDetector::JudgeEnvironment(const Crossing& crossing, double* hidden) const {
  const EnvironmentOptions& o = options_.environment;
  const RangeView& before = path_.ViewAt(crossing.at - o.settle);
  const RangeView& behind = path_.ViewAt(crossing.at + o.settle);
  // Seen before it and hidden behind it; seen behind it and hidden before it.
  const RangeView* const views[2] = {&before, &behind};
  double shares[2] = {-1.0, -1.0};
  for (int i = 0; i < 2; ++i) {
    const HiddenGround ground =
        CompareGround(*views[i], *views[1 - i], crossing.door.left, crossing.door.right, o.radius);
    if (ground.compared > o.min_compared * ground.seen) shares[i] = ground.hidden / ground.compared;
  }
  CriterionVerdict verdict;
  const double share = std::max(shares[0], shares[1]);
  *hidden = share;
  // A scanner that looks ahead only sees through the door what it sees behind it: that says nothing.
  if (std::min(shares[0], shares[1]) < 0.0) {
    *hidden = -1.0;
    verdict.state = State::kDropped;
    verdict.reason = "before and behind the door the scanner looks at different things";
    return verdict;
  }
  if (share >= o.hidden) verdict.state = State::kMet;
  verdict.reason = fmt::format("hidden behind it: {:.0f} %, before it: {:.0f} %", 100.0 * shares[0], 100.0 * shares[1]);
  return verdict;
}

PassageEvidence GapDetector::GatherEvidence(const Crossing& crossing, const DoorTrack* track) const {
  const Narrows& door = crossing.door;
  PassageEvidence evidence;
  if (track != nullptr) {
    evidence.ahead = {State::kMet, SeenAhead(track->hits, track->narrows)};
  } else {
    evidence.ahead.reason = "not seen ahead often enough";
  }
  evidence.behind = {State::kMet, crossing.reason};
  evidence.environment = JudgeEnvironment(crossing, &evidence.hidden);
  const bool seen_from_both_sides = evidence.environment.state != State::kDropped;
  evidence.walls = FindJambWalls(map_, door.left, door.right, options_.gap.wall_reach,
                                 seen_from_both_sides ? kMissingInWall : kMissingAhead);
  evidence.parallel = ParallelSurfaces(map_, door.left, door.right, 2.0 * options_.gap.parallel);
  evidence.way_round =
      map_.AreJoined(path_.PositionAt(crossing.at - kBeside), path_.PositionAt(crossing.at + kBeside),
                     {evidence.walls.left_end, evidence.walls.right_end}, {door.middle(), options_.gap.detour});
  return evidence;
}

void GapDetector::JudgeCrossing(const Crossing& crossing, std::vector<DoorEvent>& events) {
  const Narrows& door = crossing.door;
  DoorTrack* track = FindTrack(door);
  PassageEvidence evidence = GatherEvidence(crossing, track);
  PassageVerdict verdict = JudgePassage(evidence, options_);
  // What was seen ahead still counts when the place is judged again from further on.
  if (!verdict.passage) return;
  DoorEvent event = EventOf(DoorEvent::Kind::kPassage);
  event.door = track != nullptr ? track->door : 0;
  event.door_time = path_.ViewAt(crossing.at).time;
  const Eigen::Vector2d way = path_.PositionAt(crossing.at + kBeside) - path_.PositionAt(crossing.at - kBeside);
  event.T_odom_door = LookingThrough(door, way);
  event.width = door.width();
  event.ahead = std::move(evidence.ahead);
  event.behind = std::move(evidence.behind);
  event.environment = std::move(evidence.environment);
  event.reason = std::move(verdict.reason);
  last_passage_ = crossing.at;
  if (track != nullptr) track->reported = true;
  // The robot has left the side on which it latched all other doors.
  ReportCandidates(true, events);
  if (track != nullptr) std::erase_if(tracks_, [&](const DoorTrack& one) { return &one == track; });
  events.push_back(std::move(event));
}

DoorEvent GapDetector::EventOf(DoorEvent::Kind kind) const {
  DoorEvent event;
  event.kind = kind;
  event.time = path_.view().time;
  event.T_odom_robot = path_.view().T_odom_robot;
  return event;
}

DoorEvent GapDetector::CandidateOf(const DoorTrack& track, DoorEvent::Kind kind) const {
  DoorEvent event = EventOf(kind);
  event.door = track.door;
  event.T_odom_door = track.T_odom_latch;
  event.door_time = track.latch_time;
  event.width = track.narrows.width();
  event.T_odom_gap = LookingThrough(track.narrows, track.narrows.middle() - track.T_odom_latch.translation());
  event.ahead = {State::kMet, SeenAhead(track.hits, track.narrows)};
  return event;
}

// Candidates that the robot has left; `all`: every one that is not reported yet.
void GapDetector::ReportCandidates(bool all, std::vector<DoorEvent>& events) {
  const RangeView& now = path_.view();
  for (DoorTrack& track : tracks_) {
    if (track.door == 0 || track.reported || track.crossed_at >= 0.0) continue;
    const double distance = (track.narrows.middle() - now.T_odom_robot.translation()).norm();
    const bool late = ToSeconds(now.time - track.last_hit) > options_.time_limit;
    if (!all && !late && distance < kLeftBehind) continue;
    track.reported = true;
    DoorEvent event = CandidateOf(track, DoorEvent::Kind::kCandidate);
    event.reason = all    ? "seen ahead; the robot went through another door"
                   : late ? fmt::format("seen ahead, not passed within {:.0f} s", options_.time_limit)
                          : "seen ahead; the robot went elsewhere";
    events.push_back(std::move(event));
  }
}

void GapDetector::ForgetDistantTracks() {
  const Eigen::Vector2d at = path_.view().T_odom_robot.translation();
  std::erase_if(tracks_, [&](const DoorTrack& track) { return (track.narrows.middle() - at).norm() > kForgotten; });
}

void GapDetector::Finish(std::vector<DoorEvent>& events) {
  if (!path_.empty()) ReportCandidates(true, events);
}

void GapDetector::Write(BinaryWriter& writer) const {
  map_.Write(writer);
  path_.Write(writer);
  writer.Put<std::uint64_t>(tracks_.size());
  for (const DoorTrack& track : tracks_) PutTrack(writer, track);
  writer.Put(doors_);
  writer.Put(searched_);
  writer.Put(last_passage_);
}

bool GapDetector::Read(BinaryReader& reader) {
  if (!map_.Read(reader)) return false;
  path_.Read(reader);
  for (auto count = reader.Get<std::uint64_t>(); reader.ok() && count > 0; --count) {
    tracks_.push_back(GetTrack(reader));
  }
  doors_ = reader.Get<std::int64_t>();
  searched_ = reader.Get<double>();
  last_passage_ = reader.Get<double>();
  return reader.ok();
}

}  // namespace enfilade::doors
