// SPDX-License-Identifier: Apache-2.0
#include "core/doors/gap_detector.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/doors/event_codec.h"
#include "core/doors/jamb_walls.h"
#include "core/doors/passage_evidence.h"
#include "fmt/format.h"

namespace enfilade::doors {
namespace {

using State = CriterionVerdict::State;

constexpr double kPathStep = 0.05;     // m between points of the path that are kept
constexpr double kTangent = 0.4;       // m before and behind, for the way's direction
constexpr double kCrossing = 0.25;     // m about the place that is looked back on
constexpr double kMissingAhead = 0.5;  // m, kMissingInWall where a wall is seen from one side only, in passing
constexpr double kBeside = 0.5;        // m before and behind a door: is there a way round between them?
constexpr double kLeftBehind = 3.5;    // m: a latched door farther away is a candidate at once
constexpr double kForgotten = 7.0;     // m

double CrossOf(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Whether the way from p to q crosses the line between the posts.
bool Crosses(const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Narrows& door) {
  const Eigen::Vector2d edge = door.right - door.left;
  const double before = CrossOf(edge, p - door.left);
  const double behind = CrossOf(edge, q - door.left);
  if ((before > 0.0) == (behind > 0.0)) return false;
  const Eigen::Vector2d at = p + (q - p) * (before / (before - behind));
  const double t = (at - door.left).dot(edge) / edge.squaredNorm();
  return t > 0.0 && t < 1.0;
}

}  // namespace

GapDetector::GapDetector(const DoorOptions& options) : options_(options), map_(options.gap.cell, options.gap.reach) {}

void GapDetector::Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot, std::vector<DoorEvent>& events) {
  map_.Add(scan, T_odom_robot);
  const double step =
      path_.empty() ? 0.0 : (T_odom_robot.translation() - path_.back().view.T_odom_robot.translation()).norm();
  PathPoint point{(path_.empty() ? 0.0 : path_.back().travelled) + step, RangeView::Of(scan, T_odom_robot)};
  // A robot that stands still, or turns, keeps its last view only.
  const bool moved = path_.size() < 2 || point.travelled - path_[path_.size() - 2].travelled >= kPathStep;
  if (!moved) path_.pop_back();
  path_.push_back(std::move(point));
  const double kept = 2.0 * std::max(options_.gap.lag, options_.environment.settle) + 1.5;
  while (path_.size() > 2 && path_.back().travelled - path_[1].travelled > kept) path_.pop_front();

  NoteCrossings();
  LookBehind(events);
  LookAhead(events);
  TellCandidates(false, events);
  Forget();
}

std::size_t GapDetector::PathIndexAt(double travelled) const {
  const auto found = std::lower_bound(path_.begin(), path_.end(), travelled,
                                      [](const PathPoint& point, double value) { return point.travelled < value; });
  return found == path_.end() ? path_.size() - 1 : static_cast<std::size_t>(found - path_.begin());
}

Eigen::Vector2d GapDetector::PathAt(double travelled) const {
  const std::size_t i = PathIndexAt(travelled);
  const Eigen::Vector2d at = path_[i].view.T_odom_robot.translation();
  if (i == 0) return at;
  const Eigen::Vector2d before = path_[i - 1].view.T_odom_robot.translation();
  const double length = path_[i].travelled - path_[i - 1].travelled;
  if (length <= 0.0) return at;
  return before + (at - before) * std::clamp((travelled - path_[i - 1].travelled) / length, 0.0, 1.0);
}

void GapDetector::LookAhead(std::vector<DoorEvent>& events) {
  const GapOptions& o = options_.gap;
  const Pose2& pose = path_.back().view.T_odom_robot;
  const TimeNs time = path_.back().view.time;
  const Eigen::Vector2d heading(std::cos(pose.yaw), std::sin(pose.yaw));
  const NarrowsSearch search = FindNarrows(map_, pose.translation(), heading, 0.3, o.look_ahead, o);
  if (!search.narrows) return;
  const Narrows& found = *search.narrows;
  auto track = std::find_if(tracks_.begin(), tracks_.end(), [&](const Track& one) {
    return (one.narrows.middle() - found.middle()).norm() < o.same_place;
  });
  if (track == tracks_.end()) track = tracks_.insert(tracks_.end(), Track{});
  track->narrows = found;
  track->hits += 1;
  track->last_hit = time;
  track->crossed_at = -1.0;
  if (track->hits < o.hits || track->door > 0) return;
  const Eigen::Vector2d beyond = found.middle() + kBeside * heading;
  if (map_.Joined(pose.translation(), beyond, found.left, found.right, found.middle(), o.detour)) return;
  const bool beside_another = std::any_of(tracks_.begin(), tracks_.end(), [&](const Track& one) {
    return one.door > 0 && (one.narrows.middle() - found.middle()).norm() < options_.candidate_spacing;
  });
  if (beside_another) return;
  track->door = ++doors_;
  track->latch_time = time;
  track->T_odom_latch = pose;
  DoorEvent event = CandidateOf(*track, DoorEvent::Kind::kLatched);
  event.reason = search.reason;
  events.push_back(std::move(event));
}

void GapDetector::NoteCrossings() {
  if (path_.size() < 2) return;
  const PathPoint& now = path_.back();
  const PathPoint& before = path_[path_.size() - 2];
  for (Track& track : tracks_) {
    if (track.crossed_at < 0.0 && track.hits >= options_.gap.hits &&
        Crosses(before.view.T_odom_robot.translation(), now.view.T_odom_robot.translation(), track.narrows)) {
      track.crossed_at = (before.travelled + now.travelled) / 2.0;
    }
  }
}

void GapDetector::LookBehind(std::vector<DoorEvent>& events) {
  const GapOptions& o = options_.gap;
  GapOptions behind = o;
  behind.max_depth = std::max(o.max_depth, o.behind_depth);
  behind.repeated = std::max(o.repeated, o.behind_repeated);
  behind.widening = std::min(o.widening, o.behind_widening);
  // The way is looked back on piece by piece, each when the robot is `lag` behind it.
  const double until = path_.back().travelled - o.lag;
  for (; judged_ + kCrossing <= until; judged_ += kCrossing) {
    const double at = judged_ + kCrossing;
    if (at - kTangent < path_.front().travelled) continue;
    const Eigen::Vector2d middle = PathAt(at);
    Eigen::Vector2d direction = PathAt(at + kTangent) - PathAt(at - kTangent);
    if (direction.norm() < kTangent) continue;  // turned there
    direction.normalize();
    const NarrowsSearch search = FindNarrows(map_, middle, direction, -kCrossing, kCrossing, behind);
    if (search.narrows && at + search.narrows->along - last_passage_ > o.spacing) {
      Track* track = nullptr;
      for (Track& one : tracks_) {
        if (one.hits >= o.hits && (one.narrows.middle() - search.narrows->middle()).norm() < o.same_place) track = &one;
      }
      Decide(*search.narrows, track, at + search.narrows->along, search.reason, events);
    }
    for (Track& track : tracks_) {
      if (track.crossed_at < 0.0 || track.crossed_at + 2.0 * kCrossing > at) continue;
      track.hits = 0;  // done with
      track.crossed_at = -1.0;
    }
  }
}

CriterionVerdict GapDetector::JudgeEnvironment(const Narrows& door, double crossing, double* hidden) const {
  const EnvironmentOptions& o = options_.environment;
  const RangeView& before = path_[PathIndexAt(crossing - o.settle)].view;
  const RangeView& behind = path_[PathIndexAt(crossing + o.settle)].view;
  // Seen before it and hidden behind it; seen behind it and hidden before it.
  const RangeView* const views[2] = {&before, &behind};
  double shares[2] = {-1.0, -1.0};
  for (int i = 0; i < 2; ++i) {
    const HiddenGround ground = CompareGround(*views[i], *views[1 - i], door.left, door.right, o.radius);
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

void GapDetector::Decide(const Narrows& door, Track* track, double crossing, std::string behind_reason,
                         std::vector<DoorEvent>& events) {
  DoorEvent event;
  event.kind = DoorEvent::Kind::kPassage;
  event.door = track ? track->door : 0;
  event.time = path_.back().view.time;
  event.T_odom_robot = path_.back().view.T_odom_robot;
  const RangeView& at = path_[PathIndexAt(crossing)].view;
  event.door_time = at.time;
  const Eigen::Vector2d before = PathAt(crossing - kBeside);
  const Eigen::Vector2d after = PathAt(crossing + kBeside);
  Eigen::Vector2d through((door.left - door.right).y(), -(door.left - door.right).x());
  if (through.dot(after - before) < 0.0) through = -through;
  event.T_odom_door = {door.middle().x(), door.middle().y(), std::atan2(through.y(), through.x())};
  event.width = door.width();

  PassageEvidence evidence;
  if (track)
    evidence.ahead = {State::kMet,
                      fmt::format("{} scans saw {:.2f} m between posts ahead", track->hits, track->narrows.width())};
  else
    evidence.ahead.reason = "not seen ahead often enough";
  evidence.behind = {State::kMet, std::move(behind_reason)};
  evidence.environment = JudgeEnvironment(door, crossing, &evidence.hidden);
  const bool seen_from_both_sides = evidence.environment.state != State::kDropped;
  evidence.walls = FindJambWalls(map_, door.left, door.right, options_.gap.wall_reach,
                                 seen_from_both_sides ? kMissingInWall : kMissingAhead);
  evidence.parallel = ParallelSurfaces(map_, door.left, door.right, 2.0 * options_.gap.parallel);
  evidence.way_round =
      map_.Joined(before, after, evidence.walls.left_end, evidence.walls.right_end, door.middle(), options_.gap.detour);
  PassageVerdict verdict = JudgePassage(evidence, options_);
  // What was seen ahead still counts where the place is looked back on again, from further on.
  if (!verdict.passage) return;
  event.ahead = std::move(evidence.ahead);
  event.behind = std::move(evidence.behind);
  event.environment = std::move(evidence.environment);
  event.reason = std::move(verdict.reason);
  last_passage_ = crossing;
  if (track) track->told = true;
  // Whatever else was latched lies on the side that the robot has left.
  TellCandidates(true, events);
  if (track) std::erase_if(tracks_, [&](const Track& one) { return &one == track; });
  events.push_back(std::move(event));
}

DoorEvent GapDetector::CandidateOf(const Track& track, DoorEvent::Kind kind) const {
  DoorEvent event;
  event.kind = kind;
  event.door = track.door;
  event.time = path_.back().view.time;
  event.T_odom_robot = path_.back().view.T_odom_robot;
  event.T_odom_door = track.T_odom_latch;
  event.door_time = track.latch_time;
  event.width = track.narrows.width();
  event.ahead = {State::kMet,
                 fmt::format("{} scans saw {:.2f} m between posts ahead", track.hits, track.narrows.width())};
  return event;
}

void GapDetector::TellCandidates(bool all, std::vector<DoorEvent>& events) {
  const RangeView& now = path_.back().view;
  for (Track& track : tracks_) {
    if (track.door == 0 || track.told || track.crossed_at >= 0.0) continue;
    const double distance = (track.narrows.middle() - now.T_odom_robot.translation()).norm();
    const bool late = ToSeconds(now.time - track.last_hit) > options_.time_limit;
    if (!all && !late && distance < kLeftBehind) continue;
    track.told = true;
    DoorEvent event = CandidateOf(track, DoorEvent::Kind::kCandidate);
    event.reason = all    ? "seen ahead; the robot went through another door"
                   : late ? fmt::format("seen ahead, not passed within {:.0f} s", options_.time_limit)
                          : "seen ahead; the robot went elsewhere";
    events.push_back(std::move(event));
  }
}

void GapDetector::Forget() {
  const Eigen::Vector2d at = path_.back().view.T_odom_robot.translation();
  std::erase_if(tracks_, [&](const Track& track) { return (track.narrows.middle() - at).norm() > kForgotten; });
}

void GapDetector::Finish(std::vector<DoorEvent>& events) {
  if (!path_.empty()) TellCandidates(true, events);
}

void GapDetector::Write(BinaryWriter& writer) const {
  map_.Write(writer);
  writer.Put<std::uint64_t>(path_.size());
  for (const PathPoint& point : path_) {
    writer.Put(point.travelled);
    PutView(writer, point.view);
  }
  writer.Put<std::uint64_t>(tracks_.size());
  for (const Track& track : tracks_) {
    for (const double value : {track.narrows.left.x(), track.narrows.left.y(), track.narrows.right.x(),
                               track.narrows.right.y(), track.narrows.along, track.narrows.depth, track.crossed_at}) {
      writer.Put(value);
    }
    writer.Put<std::int32_t>(track.hits);
    writer.Put(track.last_hit);
    writer.Put(track.door);
    writer.Put<std::uint8_t>(track.told);
    writer.Put(track.latch_time);
    PutPose(writer, track.T_odom_latch);
  }
  writer.Put(doors_);
  writer.Put(judged_);
  writer.Put(last_passage_);
}

bool GapDetector::Read(BinaryReader& reader) {
  if (!map_.Read(reader)) return false;
  for (auto count = reader.Get<std::uint64_t>(); reader.ok() && count > 0; --count) {
    const auto travelled = reader.Get<double>();
    path_.push_back({travelled, GetView(reader)});
  }
  for (auto count = reader.Get<std::uint64_t>(); reader.ok() && count > 0; --count) {
    Track track;
    for (double* value : {&track.narrows.left.x(), &track.narrows.left.y(), &track.narrows.right.x(),
                          &track.narrows.right.y(), &track.narrows.along, &track.narrows.depth, &track.crossed_at}) {
      *value = reader.Get<double>();
    }
    track.hits = reader.Get<std::int32_t>();
    track.last_hit = reader.Get<TimeNs>();
    track.door = reader.Get<std::int64_t>();
    track.told = reader.Get<std::uint8_t>() != 0;
    track.latch_time = reader.Get<TimeNs>();
    track.T_odom_latch = GetPose(reader);
    tracks_.push_back(track);
  }
  doors_ = reader.Get<std::int64_t>();
  judged_ = reader.Get<double>();
  last_passage_ = reader.Get<double>();
  return reader.ok();
}

}  // namespace enfilade::doors
