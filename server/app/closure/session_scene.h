// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/closure/door_knowledge.h"
#include "core/closure/scan_location.h"
#include "core/closure/session_track.h"
#include "core/sensor/record.h"
#include "core/slam/slam_map.h"
#include "server/app/closure/closure_stores.h"

namespace enfilade::server {

// Records between `from` and `to`, the nearest to `time` first.
struct ViewWindow {
  TimeNs time = 0;
  TimeNs from = 0;
  TimeNs to = 0;
};

// What a session's robot saw, and where it was, around a door that it reports. A value: it holds no reference to the
// stores.
class SessionScene {
 public:
  // Empty if the session's records have been deleted. Errors are the stores'.
  static absl::StatusOr<SessionScene> Load(const DoorClosureStores& stores, const storage::Session& session,
                                           const storage::StoredDoorReport& report,
                                           const closure::DoorClosureOptions& options);

  // From the mapped scans' poses, the records around the door in the order of the log, and the covariance of the
  // keyframe nearest to the report.
  SessionScene(std::vector<slam::StampedPose> trajectory, std::vector<sensor::Record> records,
               const Eigen::Matrix3d& keyframe_covariance, const sensor::DoorReport& report,
               const closure::DoorClosureOptions& options);

  // In the session's map, with the covariance of the nearest keyframe and that of odometry since. Unset if nothing was
  // mapped around that time.
  std::optional<PoseWithCovariance> PoseAt(TimeNs time) const;
  std::optional<Pose2> OdometryAt(TimeNs time) const { return track_.OdometryAt(time); }
  // Of the reported door; of a candidate, where the robot was when it saw the door.
  std::optional<PoseWithCovariance> DoorPose() const;
  // T_door_robot when the door is reported; its covariance does not depend on how far away the map's frame is.
  std::optional<PoseWithCovariance> RobotFromDoor() const {
    return track_.RelativePose(report_.T_odom_door, report_.door_time, report_.time);
  }

  // Where odometry alone has the reported door and the robot, if there is no better pose.
  closure::DoorByOdometry GuessByOdometry() const;

  struct SeenImage {
    std::int64_t sequence = 0;
    sensor::Image image;
  };
  struct SeenCloud {
    std::int64_t sequence = 0;
    sensor::PointCloud cloud;
  };
  // `count` at most; no depth images.
  std::vector<SeenImage> FindImages(sensor::Camera camera, const ViewWindow& window, int count) const;
  std::optional<SeenCloud> FindCloud(const ViewWindow& window) const;
  // Is there an image of any camera, or a cloud?
  bool HasViews(const ViewWindow& window) const;
  // Some of the scans with from <= time <= to, from the later half of the path between, with the robot's poses.
  std::vector<closure::PlacedScan> ScansBetween(TimeNs from, TimeNs to) const;

 private:
  closure::SessionTrack track_;
  slam::StampedPose start_ = {};  // of the session in its map
  sensor::DoorReport report_;
  Eigen::Matrix3d keyframe_covariance_ = Eigen::Matrix3d::Zero();
  std::vector<SeenImage> images_;
  std::vector<SeenCloud> clouds_;
  std::vector<sensor::LaserScan> scans_;
};

}  // namespace enfilade::server
