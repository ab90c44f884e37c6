// SPDX-License-Identifier: Apache-2.0
#include "client/sources/formats/json_lines_writer.h"

#include <cmath>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "nlohmann/json.hpp"

namespace enfilade::sources {
namespace {

// The shortest text that reads back as the same bits (a JSON reader takes "-0" for the integer 0).
template <typename T>
std::string NumberText(T value) {
  return value == 0 && std::signbit(value) ? "-0.0" : fmt::format("{}", value);
}

std::string PoseText(const Pose2& pose) {
  return fmt::format(R"({{"x_m":{},"y_m":{},"yaw_rad":{}}})", NumberText(pose.x), NumberText(pose.y),
                     NumberText(pose.yaw));
}

void AppendRange(float range, std::string& out) {
  if (std::isnan(range)) {
    out += "null";
  } else if (std::isinf(range)) {
    out += range > 0.0F ? "\"inf\"" : "\"-inf\"";
  } else {
    out += NumberText(range);
  }
}

absl::Status CheckFinite(const sensor::LaserScan& scan) {
  for (const double value : {scan.angle_min, scan.angle_increment, scan.time_increment,
                             static_cast<double>(scan.range_min), static_cast<double>(scan.range_max)}) {
    if (!std::isfinite(value)) return InvalidArgument("the scan at {} ns has a non-finite parameter", scan.time);
  }
  if (!IsFinite(scan.T_robot_laser)) return InvalidArgument("the scan at {} ns has a non-finite mount", scan.time);
  return absl::OkStatus();
}

std::string Quoted(const std::filesystem::path& path) {
  return nlohmann::json(path.generic_string()).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

struct LineOf {
  const LogEntry& entry;

  absl::StatusOr<std::string> operator()(const sensor::LaserScan& scan) const {
    ENFILADE_RETURN_IF_ERROR(CheckFinite(scan));
    std::string line =
        fmt::format(R"({{"type":"scan","time_ns":{},"angle_min_rad":{},"angle_increment_rad":{},"time_increment_s":{},)"
                    R"("range_min_m":{},"range_max_m":{},"mount":{},"ranges_m":[)",
                    scan.time, scan.angle_min, scan.angle_increment, scan.time_increment, scan.range_min,
                    scan.range_max, PoseText(scan.T_robot_laser));
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      if (i > 0) line += ',';
      AppendRange(scan.ranges[i], line);
    }
    return line + "]}\n";
  }

  absl::StatusOr<std::string> operator()(const sensor::Odometry& odometry) const {
    if (!IsFinite(odometry.T_odom_robot)) return InvalidArgument("the odometry at {} ns is not finite", odometry.time);
    return fmt::format("{{\"type\":\"odometry\",\"time_ns\":{},\"pose\":{}}}\n", odometry.time,
                       PoseText(odometry.T_odom_robot));
  }

  absl::StatusOr<std::string> operator()(const sensor::Image& image) const {
    const char* camera = image.camera == sensor::Camera::kRear ? "rear" : "front";
    const char* encoding = image.encoding == sensor::ImageEncoding::kPng    ? "png"
                           : image.encoding == sensor::ImageEncoding::kJpeg ? "jpeg"
                                                                            : "depth_png16";
    return fmt::format("{{\"type\":\"image\",\"time_ns\":{},\"camera\":\"{}\",\"encoding\":\"{}\",\"file\":{}}}\n",
                       image.time, camera, encoding, Quoted(entry.content));
  }

  absl::StatusOr<std::string> operator()(const sensor::PointCloud& cloud) const {
    const char* encoding = cloud.encoding == sensor::CloudEncoding::kPcd ? "pcd" : "xyz32";
    return fmt::format("{{\"type\":\"point_cloud\",\"time_ns\":{},\"encoding\":\"{}\",\"file\":{}}}\n", cloud.time,
                       encoding, Quoted(entry.content));
  }

  absl::StatusOr<std::string> operator()(const sensor::DoorReport& report) const {
    return InvalidArgument(
        "the door report at {} ns has no place in a log file: doors are detected anew when it is read", report.time);
  }

  absl::StatusOr<std::string> operator()(const sensor::Withheld& withheld) const {
    return InvalidArgument("a withheld record (\"{}\") has no place in a log file", withheld.reason);
  }
};

}  // namespace

std::string JsonLinesHeader() { return fmt::format("{{\"type\":\"log\",\"version\":{}}}\n", kJsonLinesVersion); }

absl::StatusOr<std::string> ToJsonLine(const LogEntry& entry) { return std::visit(LineOf{entry}, entry.payload); }

}  // namespace enfilade::sources
