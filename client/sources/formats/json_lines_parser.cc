// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "client/sources/content.h"
#include "client/sources/formats/json_lines_writer.h"
#include "client/sources/formats/log_parser.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "nlohmann/json.hpp"

namespace enfilade::sources {
namespace {

using nlohmann::json;

std::string ExcerptOf(const json& value) {
  if (value.is_structured()) return std::string("an ") + value.type_name();  // dump() recurses as deep as the input
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return text.size() <= 40 ? text : text.substr(0, 40) + "...";
}

// Reads the members of one object by name. The first error stays in `status`. `Finish` refuses the members that no
// getter asked for: a misspelt unit must not be read as zero.
class Members {
 public:
  Members(const json& object, std::string path, absl::Status& status)
      : object_(object), path_(std::move(path)), status_(status) {}

  const json* Find(const std::string& name) {
    ++taken_;
    const auto member = object_.find(name);
    if (member != object_.end()) return &*member;
    --taken_;
    return nullptr;
  }
  const json* Get(const std::string& name) {
    const json* member = Find(name);
    if (!member) Fail(name, "is missing");
    return member;
  }
  double Number(const std::string& name) {
    const json* member = Get(name);
    return member ? ToNumber(name, *member) : 0.0;
  }
  double NumberOr(const std::string& name, double fallback) {
    const json* member = Find(name);
    return member ? ToNumber(name, *member) : fallback;
  }
  std::int64_t Integer(const std::string& name) {
    const json* member = Get(name);
    if (!member) return 0;
    if (!member->is_number_integer() || (member->is_number_unsigned() && member->get<std::uint64_t>() > INT64_MAX)) {
      Fail(name, "is " + ExcerptOf(*member) + ": expected an integer");
      return 0;
    }
    return member->get<std::int64_t>();
  }
  std::string Text(const std::string& name) {
    const json* member = Get(name);
    if (!member) return {};
    if (!member->is_string()) {
      Fail(name, "is " + ExcerptOf(*member) + ": expected a text");
      return {};
    }
    return member->get<std::string>();
  }
  Pose2 Pose(const std::string& name, bool required) {
    const json* member = required ? Get(name) : Find(name);
    if (!member) return {};
    if (!member->is_object()) {
      Fail(name, "is " + ExcerptOf(*member) + ": expected an object with x_m, y_m, yaw_rad");
      return {};
    }
    Members pose(*member, path_ + name + ".", status_);
    const double x = pose.Number("x_m");
    const double y = pose.Number("y_m");
    const double yaw = pose.Number("yaw_rad");
    pose.Finish();
    return {x, y, yaw};
  }
  std::vector<float> Ranges(const std::string& name) {
    const json* member = Get(name);
    if (!member) return {};
    if (!member->is_array()) {
      Fail(name, "is " + ExcerptOf(*member) + ": expected an array");
      return {};
    }
    std::vector<float> ranges;
    ranges.reserve(member->size());
    for (const json& element : *member) ranges.push_back(ToRange(name, element, ranges.size()));
    return ranges;
  }
  void Finish() {
    if (status_.ok() && taken_ != object_.size()) Fail("", "has unknown members");
  }
  void Fail(const std::string& name, const std::string& what) {
    if (!status_.ok()) return;
    status_ = InvalidArgument("{} {}", path_.empty() && name.empty() ? "the object" : path_ + name, what);
  }

 private:
  double ToNumber(const std::string& name, const json& value) {
    if (value.is_number()) return value.get<double>();
    Fail(name, "is " + ExcerptOf(value) + ": expected a number");
    return 0.0;
  }
  float ToRange(const std::string& name, const json& value, std::size_t index) {
    if (value.is_number()) return static_cast<float>(value.get<double>());
    if (value.is_null()) return std::numeric_limits<float>::quiet_NaN();
    if (value == "inf") return std::numeric_limits<float>::infinity();
    if (value == "-inf") return -std::numeric_limits<float>::infinity();
    Fail(fmt::format("{}[{}]", name, index),
         "is " + ExcerptOf(value) + ": expected a number, null, \"inf\" or \"-inf\"");
    return 0.0F;
  }

  const json& object_;
  std::string path_;
  absl::Status& status_;
  std::size_t taken_ = 0;
};

class JsonLinesParser : public LogParser {
 public:
  JsonLinesParser(const LogOptions& options, std::filesystem::path folder)
      : options_(options), folder_(std::move(folder)) {}

  void Survey(std::string_view line) override {
    // Counted by text search: parsing every line twice, only for a progress bar, would double the time.
    const std::size_t type = line.find("\"type\"");
    if (type == std::string_view::npos) return;
    const std::string_view value = line.substr(type + 6, 24);
    if (value.find("\"scan\"") != std::string_view::npos) ++scans_;
    if (value.find("\"log\"") != std::string_view::npos) return;
    if (!options_.odometry && value.find("\"odometry\"") != std::string_view::npos) return;
    ++entries_;
  }

  void Conclude(LogFacts& facts) override {
    facts.scans = scans_;
    facts.entries = entries_;
    facts.times = "time_ns";
  }

  absl::StatusOr<ParsedLine> Parse(std::string_view line) override {
    const json object = json::parse(line, nullptr, false);
    if (object.is_discarded()) return InvalidArgument("not valid JSON");
    if (!object.is_object()) return InvalidArgument("the line is {}: expected a JSON object", ExcerptOf(object));
    absl::Status status;
    Members members(object, "", status);
    const std::string type = members.Text("type");
    ParsedLine parsed;
    LogEntry entry;
    if (type == "scan") {
      entry.payload = Scan(members);
    } else if (type == "odometry") {
      entry.payload = sensor::Odometry{members.Integer("time_ns"), members.Pose("pose", true)};
    } else if (type == "image") {
      entry = ImageEntry(members, status);
    } else if (type == "point_cloud") {
      entry = CloudEntry(members, status);
    } else if (type == "log") {
      CheckVersion(members);
    } else if (status.ok()) {
      return InvalidArgument("type is \"{}\": expected log, scan, odometry, image or point_cloud", type.substr(0, 40));
    }
    members.Finish();
    if (!status.ok()) return status;
    const bool left_out = type == "log" || (type == "odometry" && !options_.odometry);
    if (!left_out) parsed.entries.push_back(std::move(entry));
    return parsed;
  }

 private:
  static void CheckVersion(Members& members) {
    const std::int64_t version = members.Integer("version");
    if (version > kJsonLinesVersion) {
      members.Fail("version", fmt::format("is {}: this program reads up to {}", version, kJsonLinesVersion));
    }
  }

  sensor::LaserScan Scan(Members& members) const {
    sensor::LaserScan scan;
    scan.time = members.Integer("time_ns");
    scan.angle_min = members.Number("angle_min_rad");
    scan.angle_increment = members.Number("angle_increment_rad");
    scan.time_increment = members.NumberOr("time_increment_s", 0.0);
    scan.range_min = static_cast<float>(members.Number("range_min_m"));
    scan.range_max = static_cast<float>(members.Number("range_max_m"));
    scan.T_robot_laser = members.Pose("mount", false);
    scan.ranges = members.Ranges("ranges_m");
    if (options_.range_max) scan.range_max = static_cast<float>(*options_.range_max);
    return scan;
  }

  sensor::BlobRef Content(Members& members, absl::Status& status, std::filesystem::path& path) const {
    const std::string name = members.Text("file");
    if (!status.ok()) return {};
    path = folder_ / name;
    const absl::StatusOr<std::string> content = ReadContent(path);
    if (!content.ok()) {
      status = InvalidArgument("file {}", std::string(content.status().message()));
      return {};
    }
    return RefOf(*content);
  }

  LogEntry ImageEntry(Members& members, absl::Status& status) const {
    sensor::Image image;
    image.time = members.Integer("time_ns");
    const std::string camera = members.Text("camera");
    const std::string encoding = members.Text("encoding");
    if (camera != "front" && camera != "rear") members.Fail("camera", "is \"" + camera + "\": expected front or rear");
    image.camera = camera == "rear" ? sensor::Camera::kRear : sensor::Camera::kFront;
    if (encoding == "png") {
      image.encoding = sensor::ImageEncoding::kPng;
    } else if (encoding == "jpeg") {
      image.encoding = sensor::ImageEncoding::kJpeg;
    } else if (encoding == "depth_png16") {
      image.encoding = sensor::ImageEncoding::kDepthPng16;
    } else {
      members.Fail("encoding", "is \"" + encoding + "\": expected png, jpeg or depth_png16");
    }
    LogEntry entry;
    image.content = Content(members, status, entry.content);
    entry.payload = image;
    return entry;
  }

  LogEntry CloudEntry(Members& members, absl::Status& status) const {
    sensor::PointCloud cloud;
    cloud.time = members.Integer("time_ns");
    const std::string encoding = members.Text("encoding");
    if (encoding != "pcd" && encoding != "xyz32") {
      members.Fail("encoding", "is \"" + encoding + "\": expected pcd or xyz32");
    }
    cloud.encoding = encoding == "xyz32" ? sensor::CloudEncoding::kXyz32 : sensor::CloudEncoding::kPcd;
    LogEntry entry;
    cloud.content = Content(members, status, entry.content);
    entry.payload = cloud;
    return entry;
  }

  LogOptions options_;
  std::filesystem::path folder_;
  std::int64_t scans_ = 0;
  std::int64_t entries_ = 0;
};

}  // namespace

std::unique_ptr<LogParser> NewJsonLinesParser(const LogOptions& options, const std::filesystem::path& folder) {
  return std::make_unique<JsonLinesParser>(options, folder);
}

}  // namespace enfilade::sources
