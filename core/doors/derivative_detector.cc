// SPDX-License-Identifier: Apache-2.0
#include "core/doors/derivative_detector.h"

#include <algorithm>
#include <cmath>

#include "core/doors/event_codec.h"
#include "core/geometry/pose2.h"
#include "fmt/format.h"

namespace enfilade::doors {
namespace {

constexpr double kTurnedRound = 120.0 * kDegree;
using State = CriterionVerdict::State;

}  // namespace

void DerivativeDetector::Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot, std::vector<DoorEvent>& events) {
  SearchAhead(scan, T_odom_robot, events);
  if (latch_ && !behind_.met()) SearchBehind(scan, T_odom_robot);
  CompareBoxes(scan, T_odom_robot);
  Conclude(scan.time, T_odom_robot, events);
  last_pose_ = T_odom_robot;
  last_time_ = scan.time;
}

void DerivativeDetector::SearchAhead(const sensor::LaserScan& scan, const Pose2& T_odom_robot,
                                     std::vector<DoorEvent>& events) {
  const DerivativeOptions& o = options_.derivative;
  if (ahead_.met()) return;
  if (ahead_hits_ > 0 && ToSeconds(scan.time - first_ahead_) > o.front_window) ahead_hits_ = 0;
  if (ahead_hits_ > 0 && ToSeconds(scan.time - last_ahead_) < o.front_spacing) return;
  const JambSearch search = FindJambsAhead(scan, o);
  if (!search.jambs) {
    if (ahead_hits_ == 0) ahead_.reason = search.reason;
    return;
  }
  if (ahead_hits_ == 0) first_ahead_ = scan.time;
  last_ahead_ = scan.time;
  if (!begin_) begin_ = scan.time;
  if (++ahead_hits_ < o.hits) return;
  ahead_ = {State::kMet, fmt::format("{} hits, {}", ahead_hits_, search.reason)};
  if (last_latched_ && Between(*last_latched_, T_odom_robot).translation().norm() <= options_.candidate_spacing) return;
  latch_ = Latch{++doors_, scan.time, T_odom_robot};
  last_latched_ = T_odom_robot;
  events.push_back(EventOf(DoorEvent::Kind::kLatched, scan.time, T_odom_robot));
}

void DerivativeDetector::SearchBehind(const sensor::LaserScan& scan, const Pose2& T_odom_robot) {
  const DerivativeOptions& o = options_.derivative;
  if (behind_hits_ > 0 && ToSeconds(scan.time - last_behind_) < o.back_spacing) return;
  JambSearch search = FindJambsBehind(scan, o);
  const double turned = std::abs(WrapAngle(T_odom_robot.yaw - latch_->T_odom_robot.yaw));
  bool turned_round = false;
  if (!search.sector_in_view) {
    if (!o.turned_stands_for_behind) {
      behind_ = {State::kDropped, search.reason};
      return;
    }
    // After the robot has turned round, the door behind it is ahead.
    turned_round = turned > kTurnedRound;
    behind_.reason = "the scanner does not look back: waiting for the door ahead after turning round";
    if (!turned_round) return;
    search = FindJambsAhead(scan, o);
  }
  if (!search.jambs) {
    behind_.reason = search.reason;
    return;
  }
  last_behind_ = scan.time;
  if (++behind_hits_ < o.hits) return;
  const double distance = Between(latch_->T_odom_robot, T_odom_robot).translation().norm();
  const bool heading_kept = turned_round || turned < o.max_heading * kDegree;
  if (distance > o.min_distance && distance < o.max_distance && heading_kept) {
    behind_ = {State::kMet, fmt::format("{} hits{}, {}, {:.1f} m on", behind_hits_,
                                        turned_round ? " ahead after turning round" : "", search.reason, distance)};
  } else {
    behind_.reason = fmt::format("seen, but {:.1f} m on and turned by {:.0f} deg", distance, turned / kDegree);
    behind_hits_ = 0;
  }
}

void DerivativeDetector::CompareBoxes(const sensor::LaserScan& scan, const Pose2& T_odom_robot) {
  const EnvironmentOptions& o = options_.environment;
  if (box_ && ToSeconds(scan.time - box_time_) < o.interval) return;
  const Eigen::AlignedBox2d box = sensor::FilteredBox(scan, o.filter_half_width, T_odom_robot);
  if (box.isEmpty()) {
    if (!environment_.met()) environment_.reason = "no beam hits anything: no box";
    return;
  }
  if (box_) {
    int changed = 0;
    const Eigen::Vector2d at = T_odom_robot.translation();
    for (const auto& [now, before] : {std::pair{box.min(), box_->min()}, {box.max(), box_->max()}}) {
      for (int axis = 0; axis < 2; ++axis) {
        if (std::abs(now[axis] - before[axis]) / 2.0 <= o.change) continue;
        const double nearer = std::min(std::abs(now[axis] - at[axis]), std::abs(before[axis] - at[axis]));
        if (!o.outdoor || nearer < o.outdoor_guard) ++changed;
      }
    }
    if (changed >= o.sides && !environment_.met()) {
      environment_ = {State::kMet, fmt::format("{} sides of the box changed", changed)};
      if (!begin_) begin_ = scan.time;
    } else if (!environment_.met()) {
      environment_.reason = fmt::format("{} sides of the box changed", changed);
    }
  }
  box_ = box;
  box_time_ = scan.time;
}

int DerivativeDetector::CountMet() const {
  return (ahead_.met() ? 1 : 0) + (behind_.met() ? 1 : 0) + (environment_.met() ? 1 : 0);
}

DoorEvent DerivativeDetector::EventOf(DoorEvent::Kind kind, TimeNs time, const Pose2& T_odom_robot) const {
  DoorEvent event;
  event.kind = kind;
  event.door = latch_ ? latch_->door : 0;
  event.time = time;
  event.T_odom_robot = T_odom_robot;
  event.T_odom_door = latch_ ? latch_->T_odom_robot : T_odom_robot;
  event.door_time = latch_ ? latch_->time : time;
  event.ahead = ahead_;
  event.behind = behind_;
  event.environment = environment_;
  return event;
}

void DerivativeDetector::Conclude(TimeNs time, const Pose2& T_odom_robot, std::vector<DoorEvent>& events) {
  if (!begin_) return;
  if (CountMet() >= options_.criteria) {
    DoorEvent event = EventOf(DoorEvent::Kind::kPassage, time, T_odom_robot);
    event.reason = fmt::format("{} of three criteria", CountMet());
    events.push_back(std::move(event));
    Reset();
  } else if (ToSeconds(time - *begin_) > options_.time_limit) {
    ReportCandidate(time, T_odom_robot, events);
    Reset();
  }
}

void DerivativeDetector::ReportCandidate(TimeNs time, const Pose2& T_odom_robot, std::vector<DoorEvent>& events) const {
  if (!latch_) return;
  DoorEvent event = EventOf(DoorEvent::Kind::kCandidate, time, T_odom_robot);
  event.reason = fmt::format("seen ahead, not passed within {:.0f} s", options_.time_limit);
  events.push_back(std::move(event));
}

void DerivativeDetector::Finish(std::vector<DoorEvent>& events) {
  ReportCandidate(last_time_, last_pose_, events);
  Reset();
}

void DerivativeDetector::Reset() {
  begin_.reset();
  latch_.reset();
  ahead_hits_ = behind_hits_ = 0;
  ahead_ = behind_ = environment_ = {};
}

void DerivativeDetector::Write(BinaryWriter& writer) const {
  writer.Put(doors_);
  PutOptional(writer, last_latched_);
  writer.Put<std::uint8_t>(begin_.has_value());
  writer.Put(begin_.value_or(0));
  writer.Put<std::int32_t>(ahead_hits_);
  writer.Put(first_ahead_);
  writer.Put(last_ahead_);
  writer.Put<std::int32_t>(behind_hits_);
  writer.Put(last_behind_);
  writer.Put<std::uint8_t>(latch_.has_value());
  const Latch latch = latch_.value_or(Latch{});
  writer.Put(latch.door);
  writer.Put(latch.time);
  PutPose(writer, latch.T_odom_robot);
  for (const CriterionVerdict* verdict : {&ahead_, &behind_, &environment_}) PutVerdict(writer, *verdict);
  writer.Put<std::uint8_t>(box_.has_value());
  const Eigen::AlignedBox2d box = box_.value_or(Eigen::AlignedBox2d(Eigen::Vector2d::Zero()));
  for (const double value : {box.min().x(), box.min().y(), box.max().x(), box.max().y()}) writer.Put(value);
  writer.Put(box_time_);
  PutPose(writer, last_pose_);
  writer.Put(last_time_);
}

bool DerivativeDetector::Read(BinaryReader& reader) {
  doors_ = reader.Get<std::int64_t>();
  last_latched_ = GetOptional(reader);
  const bool begun = reader.Get<std::uint8_t>() != 0;
  const auto begin = reader.Get<TimeNs>();
  if (begun) begin_ = begin;
  ahead_hits_ = reader.Get<std::int32_t>();
  first_ahead_ = reader.Get<TimeNs>();
  last_ahead_ = reader.Get<TimeNs>();
  behind_hits_ = reader.Get<std::int32_t>();
  last_behind_ = reader.Get<TimeNs>();
  const bool latched = reader.Get<std::uint8_t>() != 0;
  Latch latch;
  latch.door = reader.Get<std::int64_t>();
  latch.time = reader.Get<TimeNs>();
  latch.T_odom_robot = GetPose(reader);
  if (latched) latch_ = latch;
  for (CriterionVerdict* verdict : {&ahead_, &behind_, &environment_}) *verdict = GetVerdict(reader);
  const bool boxed = reader.Get<std::uint8_t>() != 0;
  Eigen::AlignedBox2d box;
  for (double* value : {&box.min().x(), &box.min().y(), &box.max().x(), &box.max().y()}) *value = reader.Get<double>();
  if (boxed) box_ = box;
  box_time_ = reader.Get<TimeNs>();
  last_pose_ = GetPose(reader);
  last_time_ = reader.Get<TimeNs>();
  return reader.ok();
}

}  // namespace enfilade::doors
