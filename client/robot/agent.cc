// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent.h"

#include <algorithm>

#include "client/sources/content.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::robot {
namespace {

using client::SpoolItem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxGathered = 256;
constexpr std::int64_t kMaxGatheredBytes = 4LL << 20;
constexpr auto kMaxGatherTime = std::chrono::milliseconds(200);
constexpr auto kSpacePoll = std::chrono::milliseconds(100);
// Kept free for door reports while what the sensors deliver is refused.
constexpr std::int64_t kReserveBytes = 16LL << 20;

StateMachineOptions MachineOptionsOf(const AgentSetup& setup) {
  StateMachineOptions options;
  options.automatic = setup.options.automatic;
  options.start = setup.start;
  options.report_behind = setup.options.evidence.report_behind;
  options.report_after = setup.options.evidence.report_after;
  return options;
}

// What of one kind is thinned and recorded apart from the others.
int SeriesOf(const SpoolItem& item) {
  const auto* image = std::get_if<sensor::Image>(&item.payload);
  if (!image) return 0;
  return 1 + 2 * static_cast<int>(image->camera) + (image->encoding == sensor::ImageEncoding::kDepthPng16 ? 1 : 0);
}

std::int64_t BytesOf(const SpoolItem& item) {
  const auto* scan = std::get_if<sensor::LaserScan>(&item.payload);
  return static_cast<std::int64_t>(item.content.size() + (scan ? scan->ranges.size() * sizeof(float) : 0)) + 256;
}

}  // namespace

Agent::Agent(AgentSetup setup, const client::Connection& connection, client::Spool& spool, Uploader& uploader,
             NewsListener listener, std::function<bool()> interrupted, EnvironmentChoice choice)
    : setup_(std::move(setup)),
      connection_(connection),
      spool_(spool),
      uploader_(uploader),
      listener_(std::move(listener)),
      interrupted_(std::move(interrupted)),
      machine_(MachineOptionsOf(setup_)),
      pairing_(sensor::ScanPairingOptions{}),
      detector_(setup_.options.doors),
      evidence_(setup_.options.evidence),
      choice_(std::move(choice)),
      last_write_(Clock::now()) {}

absl::StatusOr<std::unique_ptr<Agent>> Agent::Make(AgentSetup setup, const client::Connection& connection,
                                                   client::Spool& spool, Uploader& uploader, NewsListener listener,
                                                   std::function<bool()> interrupted) {
  ENFILADE_RETURN_IF_ERROR(setup.options.Validate());
  ENFILADE_ASSIGN_OR_RETURN(EnvironmentChoice choice, EnvironmentChoice::Make(setup.options.choice));
  for (const client::SpoolSession& session : spool.ListSessions()) {
    if (session.site == setup.site && session.robot == setup.robot) continue;
    return FailedPrecondition(
        "{}: the spool holds a session of robot \"{}\" at site \"{}\": each robot needs a spool of "
        "its own",
        spool.path(), session.robot.value(), session.site.value());
  }
  return std::unique_ptr<Agent>(new Agent(std::move(setup), connection, spool, uploader, std::move(listener),
                                          std::move(interrupted), std::move(choice)));
}

absl::Status Agent::Start() {
  Say("state", "", {{"state", NameOf(machine_.state())}});
  ENFILADE_RETURN_IF_ERROR(FinishLeftovers());
  return Handle(Ready{});
}

absl::Status Agent::FinishLeftovers() {
  for (const client::SpoolSession& session : spool_.ListSessions()) {
    if (session.closed) continue;
    const std::int64_t pending = session.pending();
    Say("leftover",
        fmt::format("session {} of an earlier run: {} records wait for the server{}", session.id.value(), pending,
                    session.finished ? "" : "; it was left open and is finished now"),
        {{"session", session.id.value()}, {"pending", pending}, {"left_open", !session.finished}});
    if (!session.finished) ENFILADE_RETURN_IF_ERROR(spool_.MarkFinished(session.id));
  }
  return absl::OkStatus();
}

absl::Status Agent::Handle(const Event& event) {
  const State before = machine_.state();
  const std::vector<Action> actions = machine_.Handle(event);
  if (machine_.state() != before) {
    const std::string name = NameOf(machine_.state());
    Say("state", fmt::format("[{}]", name), {{"state", name}});
  }
  for (const Action& action : actions) {
    ENFILADE_RETURN_IF_ERROR(std::visit([this](const auto& one) { return Act(one); }, action));
  }
  return absl::OkStatus();
}

absl::Status Agent::Add(const SpoolItem& item) {
  if (const absl::Status valid = sensor::Validate(item.payload); !valid.ok()) {
    ++counts_.invalid;
    Say("bad_input", std::string(valid.message()), {{"error", std::string(valid.message())}});
    return absl::OkStatus();
  }
  if (std::holds_alternative<sensor::LaserScan>(item.payload)) return AddScan(item);
  if (std::holds_alternative<sensor::Odometry>(item.payload)) return AddOdometry(item);
  if (std::holds_alternative<sensor::Image>(item.payload) || std::holds_alternative<sensor::PointCloud>(item.payload)) {
    return AddPicture(item);
  }
  ++counts_.invalid;  // reports and withheld records are not for sources
  return absl::OkStatus();
}

absl::Status Agent::AddScan(const SpoolItem& item) {
  if (to_begin_) ENFILADE_RETURN_IF_ERROR(BeginWithScan(item));
  if (!recording()) {
    ++counts_.ignored;
    return absl::OkStatus();
  }
  ENFILADE_RETURN_IF_ERROR(Gather(item));
  std::vector<sensor::PairedScan> settled;
  pairing_.Add(1, std::get<sensor::LaserScan>(item.payload), settled);
  return AddSettled(settled);
}

absl::Status Agent::AddOdometry(const SpoolItem& item) {
  odometry_ = std::get<sensor::Odometry>(item.payload);
  if (!recording()) {
    ++counts_.ignored;
    return absl::OkStatus();
  }
  ENFILADE_RETURN_IF_ERROR(Gather(item));
  std::vector<sensor::PairedScan> settled;
  pairing_.Add(*odometry_, settled);
  return AddSettled(settled);
}

absl::Status Agent::AddSettled(std::vector<sensor::PairedScan>& settled) {
  for (const sensor::PairedScan& scan : settled) {
    if (!scan.T_odom_robot) continue;
    choice_.Add(scan.scan);
    ENFILADE_RETURN_IF_ERROR(Handle(Moved{scan.scan.time, *scan.T_odom_robot}));
    if (!setup_.options.automatic) continue;
    for (const doors::DoorEvent& event : detector_.Add(scan.scan, *scan.T_odom_robot)) {
      ENFILADE_RETURN_IF_ERROR(Handle(DoorSeen{event}));
    }
  }
  return absl::OkStatus();
}

absl::Status Agent::AddPicture(const SpoolItem& item) {
  if (sources::RefOf(item.content) != *sensor::FindBlob(item.payload)) {
    ++counts_.invalid;
    Say("bad_input", "an image or cloud came with other bytes than its record says", {{"time_ns", TimeOf(item)}});
    return absl::OkStatus();
  }
  if (odometry_) evidence_.Add(item, odometry_->T_odom_robot);
  choice_.Add(item);
  const double hz = setup_.options.evidence.all_hz;
  if (!recording() || hz <= 0.0) return absl::OkStatus();
  const TimeNs time = TimeOf(item);
  TimeNs& next = next_picture_[SeriesOf(item)];
  if (time < next || !NewPicture(item)) return absl::OkStatus();
  const auto period = static_cast<DurationNs>(static_cast<double>(kNsPerSecond) / hz);
  // In step with the wanted rate as long as the source keeps up with it.
  next = std::max(next + period, time - period / 2 + period);
  ++counts_.evidence;
  return Gather(item);
}

void Agent::ReportPose(const OwnPose& pose) {
  const Uploader::Progress progress = uploader_.progress();
  std::string map = pose.map;
  if (!progress.map.empty() && map == progress.map) {
    map = progress.map_name;
  } else if (IsValidResourceId(map)) {
    map = convert::NameOf(convert::MapName{setup_.site, MapId(map)});
  }
  uploader_.ReportPose(map, pose.T_map_robot, pose.time);
}

absl::Status Agent::Finish() {
  std::vector<sensor::PairedScan> settled;
  pairing_.Flush(settled);
  ENFILADE_RETURN_IF_ERROR(AddSettled(settled));
  if (setup_.options.automatic && recording()) {
    for (const doors::DoorEvent& event : detector_.Finish()) ENFILADE_RETURN_IF_ERROR(Handle(DoorSeen{event}));
  }
  return Handle(SourceEnded{});
}

bool Agent::NewPicture(const SpoolItem& item) { return pictures_.emplace(SeriesOf(item), TimeOf(item)).second; }

void Agent::Keep(SpoolItem item) {
  gathered_bytes_ += BytesOf(item);
  gathered_.push_back(std::move(item));
}

absl::Status Agent::Gather(SpoolItem item) {
  Keep(std::move(item));
  const std::int64_t enough = std::min(kMaxGatheredBytes, spool_.usage().max_bytes / 8);
  const bool due =
      gathered_.size() >= kMaxGathered || gathered_bytes_ >= enough || Clock::now() - last_write_ >= kMaxGatherTime;
  return due ? WriteGathered(false) : absl::OkStatus();
}

absl::Status Agent::Flush() {
  return Clock::now() - last_write_ >= kMaxGatherTime ? WriteGathered(false) : absl::OkStatus();
}

absl::Status Agent::WriteGathered(bool essential) {
  last_write_ = Clock::now();
  if (gathered_.empty()) return absl::OkStatus();
  const client::SpoolUsage usage = spool_.usage();
  const std::int64_t reserve = std::min(kReserveBytes, usage.max_bytes / 8);
  if (!essential && !setup_.options.spool.wait_when_full) Refuse(usage, reserve);
  if (gathered_.empty()) return absl::OkStatus();
  while (true) {
    const absl::StatusOr<std::int64_t> last = spool_.Append(*session_, gathered_);
    if (last.ok()) break;
    if (!absl::IsResourceExhausted(last.status()) || spool_.usage().records == 0) return last.status();
    ENFILADE_RETURN_IF_ERROR(HoldUp(gathered_bytes_));
  }
  if (held_up_ && usage.bytes < usage.max_bytes / 2) {
    held_up_ = false;
    Say("spool_room", "the spool has room again", {{"refused", counts_.refused}});
  }
  counts_.records += static_cast<std::int64_t>(gathered_.size());
  gathered_.clear();
  gathered_bytes_ = 0;
  return absl::OkStatus();
}

void Agent::Refuse(const client::SpoolUsage& usage, std::int64_t reserve) {
  const std::int64_t free = usage.max_bytes - usage.bytes - gathered_bytes_;
  if (free >= reserve) return;
  const std::size_t before = gathered_.size();
  std::erase_if(gathered_, [&](const SpoolItem& item) {
    // A way without scans is still a way: odometry may have half of what is kept free for reports.
    const bool refused = !std::holds_alternative<sensor::Odometry>(item.payload) || free < reserve / 2;
    if (refused) gathered_bytes_ -= BytesOf(item);
    return refused;
  });
  counts_.refused += static_cast<std::int64_t>(before - gathered_.size());
  if (std::exchange(held_up_, true)) return;
  Say("spool_full", "the spool is full: what the sensors deliver is refused until the server takes some of it",
      {{"refused", counts_.refused}});
}

absl::Status Agent::HoldUp(std::int64_t bytes) {
  if (!std::exchange(held_up_, true)) {
    Say("spool_full", "the spool is full: the source waits until the server takes some of it");
  }
  if (interrupted_()) return absl::CancelledError("interrupted while the spool was full");
  spool_.WaitForSpace(bytes, Clock::now() + kSpacePoll);
  return absl::OkStatus();
}

void Agent::Say(std::string event, std::string text, nlohmann::json fields) {
  listener_({std::move(event), std::move(text), std::move(fields)});
}

}  // namespace enfilade::robot
