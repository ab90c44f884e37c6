// SPDX-License-Identifier: Apache-2.0
#include "core/doors/door_detector.h"

#include <utility>

#include "core/base/binary.h"
#include "core/base/error.h"

namespace enfilade::doors {
namespace {

constexpr std::uint8_t kVersion = 2;

std::variant<GapDetector, DerivativeDetector> Make(const DoorOptions& options) {
  if (options.method == DoorMethod::kGap) return GapDetector(options);
  return DerivativeDetector(options);
}

}  // namespace

DoorDetector::DoorDetector(const DoorOptions& options) : detector_(Make(options)) {}

std::vector<DoorEvent> DoorDetector::Add(const sensor::LaserScan& scan, const Pose2& T_odom_robot) {
  std::vector<DoorEvent> events;
  if (!sensor::Validate(scan).ok() || !IsFinite(T_odom_robot) || scan.time < last_time_) return events;
  last_time_ = scan.time;
  std::visit([&](auto& detector) { detector.Add(scan, T_odom_robot, events); }, detector_);
  return events;
}

std::vector<DoorEvent> DoorDetector::Finish() {
  std::vector<DoorEvent> events;
  if (auto* gaps = std::get_if<GapDetector>(&detector_)) gaps->Finish(events);
  if (auto* derivatives = std::get_if<DerivativeDetector>(&detector_)) derivatives->Finish(events);
  return events;
}

std::string DoorDetector::Serialize() const {
  std::string bytes;
  BinaryWriter writer(bytes);
  writer.Put(kVersion);
  writer.Put(static_cast<std::uint8_t>(detector_.index()));
  writer.Put(last_time_);
  std::visit([&](const auto& detector) { detector.Write(writer); }, detector_);
  return bytes;
}

absl::StatusOr<DoorDetector> DoorDetector::Restore(const DoorOptions& options, std::string_view bytes) {
  BinaryReader reader(bytes);
  if (const auto version = reader.Get<std::uint8_t>(); version != kVersion) {
    return DataLoss("door detector: state version {} is unknown to this program", version);
  }
  DoorDetector detector(options);
  if (reader.Get<std::uint8_t>() != detector.detector_.index()) {
    return DataLoss("door detector: the state is of another method than the options");
  }
  detector.last_time_ = reader.Get<TimeNs>();
  const bool read = std::visit([&](auto& one) { return one.Read(reader); }, detector.detector_);
  if (!read || !reader.at_end()) {
    return DataLoss("door detector: a state of {} bytes is truncated, has trailing bytes, or is of other options",
                    bytes.size());
  }
  return detector;
}

}  // namespace enfilade::doors
