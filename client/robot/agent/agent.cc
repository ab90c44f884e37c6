// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/agent.h"

#include <algorithm>

#include "client/sources/content.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::robot {
namespace {

using client::SpoolItem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxBuffered = 256;
constexpr std::int64_t kMaxBufferedBytes = 4LL << 20;
constexpr auto kMaxBufferTime = std::chrono::milliseconds(200);
constexpr auto kSpacePoll = std::chrono::milliseconds(100);
// Reserved for door reports while sensor data is refused.
constexpr std::int64_t kReserveBytes = 16LL << 20;

StateMachineOptions MachineOptionsOf(const AgentSetup& setup) {
  StateMachineOptions options;
  options.automatic = setup.options.automatic;
  options.start = setup.start;
  options.report_behind = setup.options.evidence.report_behind;
  options.report_after = setup.options.evidence.report_after;
  options.report_standing = setup.options.evidence.report_standing;
  return options;
}

// Images of each camera and encoding, clouds, scans and odometry, each at their own rate.
int SeriesOf(const SpoolItem& item) {
  const auto* image = std::get_if<sensor::Image>(&item.payload);
  if (!image) return -static_cast<int>(item.payload.index());
  return 1 + 2 * static_cast<int>(image->camera) + (image->encoding == sensor::ImageEncoding::kDepthPng16 ? 1 : 0);
}

std::int64_t BytesOf(const SpoolItem& item) {
  const auto* scan = std::get_if<sensor::LaserScan>(&item.payload);
  return static_cast<std::int64_t>(item.content.size() + (scan ? scan->ranges.size() * sizeof(float) : 0)) + 256;
}

}  // namespace

Agent::Agent(AgentSetup setup, AgentContext context, EnvironmentClassifier classifier)
    : setup_(std::move(setup)),
      context_(std::move(context)),
      machine_(MachineOptionsOf(setup_)),
      pairing_(sensor::ScanPairingOptions{}),
      detector_(setup_.options.doors),
      evidence_(setup_.options.evidence),
      classifier_(std::move(classifier)),
      last_write_(Clock::now()) {}

absl::StatusOr<std::unique_ptr<Agent>> Agent::Make(AgentSetup setup, AgentContext context) {
  ENFILADE_RETURN_IF_ERROR(setup.options.Validate());
  ENFILADE_ASSIGN_OR_RETURN(EnvironmentClassifier classifier, EnvironmentClassifier::Make(setup.options.environment));
  for (const client::SpoolSession& session : context.spool.ListSessions()) {
    if (session.site == setup.site && session.robot == setup.robot) continue;
    return FailedPrecondition("{}: the spool holds a session of robot \"{}\" at site \"{}\": each robot needs its own",
                              context.spool.path(), session.robot.value(), session.site.value());
  }
  return std::unique_ptr<Agent>(new Agent(std::move(setup), std::move(context), std::move(classifier)));
}

absl::Status Agent::Start() {
  Notify("state", "", {{"state", NameOf(machine_.state())}});
  ENFILADE_RETURN_IF_ERROR(FinishLeftovers());
  return Handle(Ready{});
}

absl::Status Agent::FinishLeftovers() {
  for (const client::SpoolSession& session : context_.spool.ListSessions()) {
    if (session.closed) continue;
    const std::int64_t pending = session.pending();
    Notify("leftover",
           fmt::format("session {} of an earlier run: {} records wait for the server{}", session.id.value(), pending,
                       session.finished ? "" : "; it was left open and is now finished"),
           {{"session", session.id.value()}, {"pending", pending}, {"left_open", !session.finished}});
    if (!session.finished) ENFILADE_RETURN_IF_ERROR(context_.spool.MarkFinished(session.id));
  }
  return absl::OkStatus();
}

absl::Status Agent::Handle(const Event& event) {
  const State before = machine_.state();
  const std::vector<Action> actions = machine_.Handle(event);
  if (machine_.state() != before) {
    const std::string name = NameOf(machine_.state());
    Notify("state", fmt::format("[{}]", name), {{"state", name}});
  }
  for (const Action& action : actions) {
    ENFILADE_RETURN_IF_ERROR(std::visit([this](const auto& one) { return Execute(one); }, action));
  }
  return absl::OkStatus();
}

absl::Status Agent::Add(const SpoolItem& item) {
  if (const absl::Status valid = sensor::Validate(item.payload); !valid.ok()) {
    ++counts_.invalid;
    Notify("bad_input", std::string(valid.message()), {{"error", std::string(valid.message())}});
    return absl::OkStatus();
  }
  const DurationNs ahead = clock_.ahead();
  const std::optional<TimeNs> time = clock_.Adjust(SeriesOf(item), TimeOf(item));
  if (clock_.ahead() != ahead) {
    const double back = ToSeconds(clock_.ahead() - ahead);
    Notify("clock", fmt::format("the clock went back by {:.1f} s; recorded times continue without a step", back),
           {{"back_s", back}});
  }
  if (!time) {
    ++counts_.invalid;
    Notify("bad_input", "a record's time is out of order, or far ahead of those before it",
           {{"time_ns", TimeOf(item)}});
    return absl::OkStatus();
  }
  if (*time == TimeOf(item)) return AddValid(item);
  SpoolItem adjusted = item;
  std::visit(
      [&](auto& payload) {
        if constexpr (requires { payload.time; }) payload.time = *time;
      },
      adjusted.payload);
  return AddValid(adjusted);
}

// What may not continue what was before is held back until that is known. Continuity needs the newest odometry, held or
// not; once it is taken, AddOdometry sets it again, in its turn.
absl::Status Agent::AddValid(const SpoolItem& item) {
  if (const auto* odometry = std::get_if<sensor::Odometry>(&item.payload)) odometry_ = *odometry;
  if (const auto* scan = std::get_if<sensor::LaserScan>(&item.payload); scan != nullptr && odometry_) {
    if (const auto broken = continuity_.Add(*scan, odometry_->T_odom_robot)) {
      counts_.ignored += static_cast<std::int64_t>(std::exchange(held_, {}).size());
      ENFILADE_RETURN_IF_ERROR(Handle(Interrupted{*broken}));
    }
  }
  if (setup_.options.automatic && recording() && continuity_.suspicious()) {
    held_.push_back(item);
    return absl::OkStatus();
  }
  ENFILADE_RETURN_IF_ERROR(ReleaseHeld());
  return Take(item);
}

absl::Status Agent::ReleaseHeld() {
  for (const SpoolItem& item : std::exchange(held_, {})) ENFILADE_RETURN_IF_ERROR(Take(item));
  return absl::OkStatus();
}

absl::Status Agent::Take(const SpoolItem& item) {
  if (std::holds_alternative<sensor::LaserScan>(item.payload)) return AddScan(item);
  if (std::holds_alternative<sensor::Odometry>(item.payload)) return AddOdometry(item);
  if (std::holds_alternative<sensor::Image>(item.payload) || std::holds_alternative<sensor::PointCloud>(item.payload)) {
    return AddEvidence(item);
  }
  ++counts_.invalid;  // a source cannot give reports or withheld records
  return absl::OkStatus();
}

absl::Status Agent::AddScan(const SpoolItem& item) {
  if (to_begin_ && (!to_begin_->when_settled || continuity_.settled())) {
    ENFILADE_RETURN_IF_ERROR(BeginWithScan(item));
  }
  if (!recording()) {
    ++counts_.ignored;
    return absl::OkStatus();
  }
  ENFILADE_RETURN_IF_ERROR(Buffer(item));
  std::vector<sensor::PairedScan> settled;
  pairing_.Add(1, std::get<sensor::LaserScan>(item.payload), settled);
  return AddPairedScans(settled);
}

absl::Status Agent::AddOdometry(const SpoolItem& item) {
  odometry_ = std::get<sensor::Odometry>(item.payload);
  if (!recording()) {
    ++counts_.ignored;
    return absl::OkStatus();
  }
  ENFILADE_RETURN_IF_ERROR(Buffer(item));
  std::vector<sensor::PairedScan> settled;
  pairing_.Add(*odometry_, settled);
  return AddPairedScans(settled);
}

absl::Status Agent::AddPairedScans(std::vector<sensor::PairedScan>& scans) {
  for (const sensor::PairedScan& scan : scans) {
    if (!scan.T_odom_robot) continue;
    classifier_.Add(scan.scan);
    if (start_) ENFILADE_RETURN_IF_ERROR(LookAround(scan));
    ENFILADE_RETURN_IF_ERROR(Handle(Moved{scan.scan.time, *scan.T_odom_robot}));
    if (!setup_.options.automatic) continue;
    for (const doors::DoorEvent& event : detector_.Add(scan.scan, *scan.T_odom_robot)) {
      ENFILADE_RETURN_IF_ERROR(Handle(DoorDetected{event}));
    }
  }
  return absl::OkStatus();
}

absl::Status Agent::AddEvidence(const SpoolItem& item) {
  if (sources::RefOf(item.content) != *sensor::FindBlob(item.payload)) {
    ++counts_.invalid;
    Notify("bad_input", "an image's or cloud's bytes do not match its record", {{"time_ns", TimeOf(item)}});
    return absl::OkStatus();
  }
  if (odometry_) evidence_.Add(item, odometry_->T_odom_robot);
  classifier_.Add(item);
  const double hz = setup_.options.evidence.all_hz;
  if (!recording() || hz <= 0.0) return absl::OkStatus();
  const TimeNs time = TimeOf(item);
  TimeNs& next = next_evidence_[SeriesOf(item)];
  if (time < next || !MarkRecorded(item)) return absl::OkStatus();
  const auto period = static_cast<DurationNs>(static_cast<double>(kNsPerSecond) / hz);
  // On the grid of the requested rate while the source keeps up with it.
  next = std::max(next + period, time - period / 2 + period);
  ++counts_.evidence;
  return Buffer(item);
}

void Agent::ReportPose(const PoseReport& report) {
  const Uploader::Progress progress = context_.uploader.progress();
  std::string map = report.map;
  if (!progress.map.empty() && map == progress.map) {
    map = progress.map_name;
  } else if (IsValidResourceId(map)) {
    map = convert::NameOf(convert::MapName{setup_.site, MapId(map)});
  }
  context_.uploader.ReportPose(map, report.T_map_robot, report.time + clock_.ahead());
}

absl::Status Agent::Finish() {
  ENFILADE_RETURN_IF_ERROR(ReleaseHeld());
  std::vector<sensor::PairedScan> settled;
  pairing_.Flush(settled);
  ENFILADE_RETURN_IF_ERROR(AddPairedScans(settled));
  if (setup_.options.automatic && recording()) {
    for (const doors::DoorEvent& event : detector_.Finish()) ENFILADE_RETURN_IF_ERROR(Handle(DoorDetected{event}));
  }
  return Handle(SourceEnded{});
}

bool Agent::MarkRecorded(const SpoolItem& item) { return recorded_.emplace(SeriesOf(item), TimeOf(item)).second; }

void Agent::Append(SpoolItem item) {
  buffered_bytes_ += BytesOf(item);
  buffer_.push_back(std::move(item));
}

absl::Status Agent::Buffer(SpoolItem item) {
  Append(std::move(item));
  const std::int64_t enough = std::min(kMaxBufferedBytes, context_.spool.usage().max_bytes / 8);
  const bool due =
      buffer_.size() >= kMaxBuffered || buffered_bytes_ >= enough || Clock::now() - last_write_ >= kMaxBufferTime;
  return due ? WriteBuffer(false) : absl::OkStatus();
}

absl::Status Agent::Flush() {
  return Clock::now() - last_write_ >= kMaxBufferTime ? WriteBuffer(false) : absl::OkStatus();
}

absl::Status Agent::WriteBuffer(bool essential) {
  last_write_ = Clock::now();
  if (buffer_.empty()) return absl::OkStatus();
  const client::SpoolUsage usage = context_.spool.usage();
  if (!essential && !setup_.options.spool.wait_when_full) RefuseWhenFull(usage);
  if (buffer_.empty()) return absl::OkStatus();
  while (true) {
    const absl::StatusOr<std::int64_t> last = context_.spool.Append(*session_, buffer_);
    if (last.ok()) break;
    if (!absl::IsResourceExhausted(last.status()) || context_.spool.usage().records == 0) return last.status();
    ENFILADE_RETURN_IF_ERROR(WaitForSpace(buffered_bytes_));
  }
  if (spool_full_ && usage.bytes < usage.max_bytes / 2) {
    spool_full_ = false;
    Notify("spool_room", "the spool has space again", {{"refused", counts_.refused}});
  }
  counts_.records += static_cast<std::int64_t>(buffer_.size());
  buffer_.clear();
  buffered_bytes_ = 0;
  return absl::OkStatus();
}

void Agent::RefuseWhenFull(const client::SpoolUsage& usage) {
  const std::int64_t reserve = std::min(kReserveBytes, usage.max_bytes / 8);
  const std::int64_t free = usage.max_bytes - usage.bytes - buffered_bytes_;
  if (free >= reserve) return;
  const std::size_t before = buffer_.size();
  std::erase_if(buffer_, [&](const SpoolItem& item) {
    // Odometry is useful even without scans: it may fill half of the reserve.
    const bool refused = !std::holds_alternative<sensor::Odometry>(item.payload) || free < reserve / 2;
    if (refused) buffered_bytes_ -= BytesOf(item);
    return refused;
  });
  counts_.refused += static_cast<std::int64_t>(before - buffer_.size());
  if (std::exchange(spool_full_, true)) return;
  Notify("spool_full", "the spool is full: sensor data is refused until the server has taken some of it",
         {{"refused", counts_.refused}});
}

absl::Status Agent::WaitForSpace(std::int64_t bytes) {
  if (!std::exchange(spool_full_, true)) {
    Notify("spool_full", "the spool is full: the source waits until the server has taken some of it");
  }
  if (context_.interrupted()) return absl::CancelledError("interrupted while the spool was full");
  context_.spool.WaitForSpace(bytes, Clock::now() + kSpacePoll);
  return absl::OkStatus();
}

void Agent::Notify(std::string event, std::string text, nlohmann::json fields) {
  context_.listener({std::move(event), std::move(text), std::move(fields)});
}

}  // namespace enfilade::robot
