// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/closure/door_knowledge.h"
#include "server/app/closure/session_scene.h"

namespace enfilade::server {

// A robot that drives east at 0.5 m/s, mapped and with odometry each half second from 0 s to 20 s; both frames are the
// same but for 100 m. It passes a door at 10 s (x = 5 m) and reports that at 13 s (x = 6.5 m).
class PassedDoorLog {
 public:
  PassedDoorLog() {
    report_.kind = sensor::DoorReport::Kind::kPassage;
    report_.door_time = At(10.0);
    report_.time = At(13.0);
    report_.T_odom_door = {105, 0, 0};
    for (double t = 0.0; t <= 20.0; t += 0.5) {
      trajectory_.push_back({At(t), {0.5 * t, 0, 0}});
      Add(sensor::Odometry{.time = At(t), .T_odom_robot = {100 + 0.5 * t, 0, 0}});
    }
  }

  static TimeNs At(double seconds) { return DurationOf(seconds); }

  // Returns the record's sequence.
  std::int64_t Add(sensor::RecordPayload payload) {
    records_.push_back({next_, std::move(payload)});
    return next_++;
  }
  std::int64_t AddImage(double seconds, sensor::Camera camera,
                        sensor::ImageEncoding encoding = sensor::ImageEncoding::kJpeg) {
    return Add(sensor::Image{.time = At(seconds), .camera = camera, .encoding = encoding, .content = NextContent()});
  }
  std::int64_t AddCloud(double seconds) {
    return Add(
        sensor::PointCloud{.time = At(seconds), .encoding = sensor::CloudEncoding::kXyz32, .content = NextContent()});
  }
  std::int64_t AddScan(double seconds) {
    sensor::LaserScan scan;
    scan.time = At(seconds);
    scan.angle_increment = 0.1;
    scan.range_max = 10.0F;
    scan.ranges = {1.0F, 2.0F};
    return Add(std::move(scan));
  }

  sensor::DoorReport& report() { return report_; }
  void ForgetTrajectory() { trajectory_.clear(); }

  SessionScene Scene() const { return {trajectory_, records_, KeyframeCovariance(), report_, options_}; }

  static Eigen::Matrix3d KeyframeCovariance() { return Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal(); }

  // What is known of the passage, without a graph.
  closure::DoorKnowledge Knowledge() const {
    const SessionScene scene = Scene();
    closure::DoorKnowledge knowledge;
    knowledge.options = options_;
    knowledge.report = report_;
    knowledge.map = closure::SessionMap{.id = MapId("here")};
    knowledge.T_map_door = scene.DoorPose();
    knowledge.T_map_robot = scene.PoseAt(report_.time);
    return knowledge;
  }

 private:
  sensor::BlobRef NextContent() const { return {std::string(32, static_cast<char>('a' + next_ % 26)), next_}; }

  closure::DoorClosureOptions options_;
  sensor::DoorReport report_;
  std::vector<slam::StampedPose> trajectory_;
  std::vector<sensor::Record> records_;
  std::int64_t next_ = 1;
};

}  // namespace enfilade::server
