// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/closure_options.h"
#include "core/closure/scan_location.h"
#include "core/closure/session_track.h"
#include "core/sensor/record.h"
#include "server/app/closure/closure_stores.h"

namespace enfilade::server {

// What a session's robot saw, and where it was, about a door that it reports. A value; the stores are not kept.
class SessionScene {
 public:
  // Errors are the stores'. A session whose records are gone has none.
  static absl::StatusOr<SessionScene> Load(const DoorClosureStores& stores, const storage::CallContext& context,
                                           const storage::Session& session, const storage::StoredDoorReport& report,
                                           const closure::DoorClosureOptions& options);

  // In the session's map, with the covariance of the nearest keyframe and odometry's since. Unset where nothing was
  // mapped about then.
  std::optional<PoseWithCovariance> PoseAt(TimeNs time) const;
  std::optional<Pose2> OdometryAt(TimeNs time) const { return track_.OdometryAt(time); }
  // The report's door; of a candidate where the robot was when it saw the door.
  std::optional<PoseWithCovariance> DoorPose() const;
  // T_door_robot when it is reported, with what is unsure of it whatever the map's frame is away.
  std::optional<PoseWithCovariance> RobotFromDoor() const {
    return track_.WayFrom(report_.T_odom_door, report_.door_time, report_.time);
  }

  struct SeenImage {
    std::int64_t sequence = 0;
    sensor::Image image;
  };
  struct SeenCloud {
    std::int64_t sequence = 0;
    sensor::PointCloud cloud;
  };
  // At most `count` with from <= time <= to, the nearest to `time` first.
  std::vector<SeenImage> ImagesNear(sensor::Camera camera, TimeNs time, TimeNs from, TimeNs to, int count) const;
  std::optional<SeenCloud> CloudNear(TimeNs time, TimeNs from, TimeNs to) const;
  // A few of the scans with from <= time <= to, in the later half of the way between, with the robot's poses.
  std::vector<closure::PlacedScan> ScansBetween(TimeNs from, TimeNs to) const;

 private:
  SessionScene(closure::SessionTrack track, const sensor::DoorReport& report)
      : track_(std::move(track)), report_(report) {}

  closure::SessionTrack track_;
  sensor::DoorReport report_;
  Eigen::Matrix3d keyframe_covariance_ = Eigen::Matrix3d::Zero();
  std::vector<SeenImage> images_;
  std::vector<SeenCloud> clouds_;
  std::vector<sensor::LaserScan> scans_;
};

}  // namespace enfilade::server
