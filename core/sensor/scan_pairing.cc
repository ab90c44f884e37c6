// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/scan_pairing.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "core/base/binary.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/sensor/record_codec.h"

namespace enfilade::sensor {
namespace {

constexpr std::uint8_t kPairingVersion = 1;
// Odometry that is older than the newest by more than this cannot serve a future scan.
constexpr DurationNs kHistoryNs = 60 * kNsPerSecond;

DurationNs WindowNs(const ScanPairingOptions& options) {
  return static_cast<DurationNs>(std::llround(options.window_s * 1e9));
}

}  // namespace

void ScanPairing::Add(std::int64_t sequence, LaserScan scan, std::vector<PairedScan>& settled) {
  if (scan.time < latest_scan_) {
    ++counts_.time_reversed;
    return;
  }
  latest_scan_ = scan.time;
  waiting_.push_back({sequence, std::move(scan)});
  Settle(false, settled);
}

void ScanPairing::Add(const Odometry& odometry, std::vector<PairedScan>& settled) {
  if (!odometry_.empty() && odometry.time < odometry_.back().time) {
    ++counts_.time_reversed;
    return;
  }
  odometry_.push_back(odometry);
  // Bounds the queue for a robot that sends no scans.
  while (waiting_.empty() && odometry_.size() > 1 && odometry_[1].time < odometry.time - kHistoryNs) {
    odometry_.pop_front();
  }
  Settle(false, settled);
}

void ScanPairing::Add(std::int64_t sequence, RecordPayload payload, std::vector<PairedScan>& settled) {
  if (auto* scan = std::get_if<LaserScan>(&payload)) {
    Add(sequence, std::move(*scan), settled);
  } else if (const auto* odometry = std::get_if<Odometry>(&payload)) {
    Add(*odometry, settled);
  }
}

void ScanPairing::Flush(std::vector<PairedScan>& settled) { Settle(true, settled); }

// Settles scans, oldest first, while future odometry cannot change their pose.
void ScanPairing::Settle(bool flush, std::vector<PairedScan>& settled) {
  while (!waiting_.empty()) {
    Waiting& oldest = waiting_.front();
    const bool wait = NextOdometryMayImprove(oldest.scan.time) && waiting_.size() <= options_.max_waiting_scans;
    if (wait && !flush) return;
    PairedScan paired{oldest.sequence, std::move(oldest.scan), std::nullopt};
    waiting_.pop_front();
    paired.T_odom_robot = PoseAt(paired.scan.time);
    ++(paired.T_odom_robot ? counts_.paired : counts_.unpaired);
    while (odometry_.size() > 1 && odometry_[1].time <= paired.scan.time) odometry_.pop_front();
    settled.push_back(std::move(paired));
  }
}

// Whether odometry at or after `time` and within the window may still arrive: none has arrived yet, and the newest scan
// is not past the window.
bool ScanPairing::NextOdometryMayImprove(TimeNs time) const {
  if (!odometry_.empty() && odometry_.back().time >= time) return false;
  return latest_scan_ <= time + WindowNs(options_);
}

std::optional<Pose2> ScanPairing::PoseAt(TimeNs time) const {
  const auto after =
      std::find_if(odometry_.begin(), odometry_.end(), [&](const Odometry& o) { return o.time >= time; });
  const DurationNs window = WindowNs(options_);
  const bool has_after = after != odometry_.end() && after->time - time <= window;
  const bool has_before = after != odometry_.begin() && time - std::prev(after)->time <= window;
  if (has_after && after->time == time) return after->T_odom_robot;
  if (has_after && has_before) {
    const Odometry& before = *std::prev(after);
    const double t = static_cast<double>(time - before.time) / static_cast<double>(after->time - before.time);
    return Interpolate(before.T_odom_robot, after->T_odom_robot, t);
  }
  if (has_after) return after->T_odom_robot;
  if (has_before) return std::prev(after)->T_odom_robot;
  return std::nullopt;
}

std::string ScanPairing::Serialize() const {
  std::string bytes;
  BinaryWriter writer(bytes);
  writer.Put(kPairingVersion);
  writer.Put(counts_.paired);
  writer.Put(counts_.unpaired);
  writer.Put(counts_.time_reversed);
  writer.Put(latest_scan_);
  writer.Put<std::uint64_t>(waiting_.size());
  for (const Waiting& waiting : waiting_) {
    writer.Put(waiting.sequence);
    writer.PutString(EncodePayload(Record{waiting.sequence, waiting.scan}));
  }
  writer.Put<std::uint64_t>(odometry_.size());
  for (const Odometry& odometry : odometry_) writer.PutString(EncodePayload(Record{1, odometry}));
  return bytes;
}

absl::StatusOr<ScanPairing> ScanPairing::Restore(const ScanPairingOptions& options, std::string_view bytes) {
  BinaryReader reader(bytes);
  ScanPairing pairing(options);
  if (reader.Get<std::uint8_t>() != kPairingVersion)
    return DataLoss("scan pairing: unknown version of the stored state");
  pairing.counts_.paired = reader.Get<std::int64_t>();
  pairing.counts_.unpaired = reader.Get<std::int64_t>();
  pairing.counts_.time_reversed = reader.Get<std::int64_t>();
  pairing.latest_scan_ = reader.Get<TimeNs>();
  for (auto n = reader.Get<std::uint64_t>(); n > 0 && reader.ok(); --n) {
    const auto sequence = reader.Get<std::int64_t>();
    ENFILADE_ASSIGN_OR_RETURN(Record record, DecodePayload(sequence, RecordKind::kLaserScan, reader.GetString()));
    pairing.waiting_.push_back({sequence, std::get<LaserScan>(std::move(record.payload))});
  }
  for (auto n = reader.Get<std::uint64_t>(); n > 0 && reader.ok(); --n) {
    ENFILADE_ASSIGN_OR_RETURN(const Record record, DecodePayload(1, RecordKind::kOdometry, reader.GetString()));
    pairing.odometry_.push_back(std::get<Odometry>(record.payload));
  }
  if (!reader.at_end()) return DataLoss("scan pairing: the stored state is truncated or has trailing bytes");
  return pairing;
}

}  // namespace enfilade::sensor
