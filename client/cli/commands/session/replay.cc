// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "client/cli/commands/commands.h"
#include "client/cli/interrupt.h"
#include "client/cli/log_options.h"
#include "client/cli/numbers.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/cli/replay/log_feeder.h"
#include "client/cli/replay/replay_report.h"
#include "client/cli/replay/replay_session.h"
#include "client/sdk/uplink/session_setup.h"
#include "client/sdk/uplink/uplink.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"

namespace enfilade::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPoll = std::chrono::milliseconds(100);

absl::Status CheckReplay(const ReplayOptions& options) {
  if (options.map.empty() == !options.record_only) {
    return InvalidArgument("give either --map, the map for the log, or --record-only");
  }
  ENFILADE_RETURN_IF_ERROR(EntryOf(options.entry).status());
  if (!options.entry.at.empty() && options.record_only) {
    return InvalidArgument("--at is a pose in a map: it cannot be combined with --record-only");
  }
  if (!IsValidResourceId(options.robot)) {
    return InvalidArgument("--robot is \"{}\": expected 1 to 63 of a-z, 0-9 and \"-\"", options.robot);
  }
  if (!options.session.empty() && !IsValidResourceId(options.session)) {
    return InvalidArgument("--session is \"{}\": expected 1 to 63 of a-z, 0-9 and \"-\"", options.session);
  }
  if (!(options.spool_mib >= 1.0)) return InvalidArgument("--spool-mib is {}: expected 1 or more", options.spool_mib);
  return ParseRate(options.rate).status();
}

absl::StatusOr<CheckedLog> CheckLogWithProgress(const Globals& globals, const ReplayOptions& options) {
  ProgressBar bar(globals, "checking", 0, "entries");
  return CheckLog(options.log, options.reading, [&](std::int64_t entries) { bar.Update(entries); });
}

// Reports each new reason why the server does not take records, once.
class TroubleReport {
 public:
  explicit TroubleReport(const Globals& globals) : shown_(!globals.quiet) {}

  void Update(const client::UplinkProgress& progress) {
    if (progress.last_error == last_) return;
    last_ = progress.last_error;
    if (shown_ && !last_.empty()) {
      std::cerr << "\nenfilade: " << last_ << "; trying again (no records are lost; Ctrl-C stops)" << std::endl;
    }
  }

 private:
  bool shown_;
  std::string last_;
};

// Feeds the spool, and waits until the uplink has sent everything.
absl::Status Transfer(const Globals& globals, LogFeeder& feeder, client::Spool& spool, const InterruptGuard& interrupt,
                      ReplayResult& result) {
  client::Uplink uplink(ConnectionOf(globals), spool, result.session);
  uplink.Start();
  ProgressBar bar(globals, "sending", result.log.entries, "records");
  TroubleReport trouble(globals);
  bool feeding = !spool.FindSession(result.session)->finished;
  std::optional<absl::Status> end;
  while (!(end = uplink.WaitFor(std::chrono::seconds(0)))) {
    result.uplink = uplink.progress();
    if (interrupt.interrupted()) return absl::CancelledError("interrupted");
    bar.Update(result.uplink.acknowledged_sequence);
    trouble.Update(result.uplink);
    const auto now = Clock::now();
    if (feeding) {
      ENFILADE_ASSIGN_OR_RETURN(feeding, feeder.Feed(now));
      if (!feeding) ENFILADE_RETURN_IF_ERROR(spool.MarkFinished(result.session));
      if (feeder.spool_is_full()) {
        spool.WaitForSpace(1 << 20, now + kPoll);
      } else if (const auto due = feeder.next_due(now); feeding && due > now) {
        std::this_thread::sleep_until(std::min<Clock::time_point>(due, now + kPoll));
      }
    } else {
      end = uplink.WaitFor(kPoll);
    }
  }
  result.uplink = uplink.progress();
  if (end->ok()) bar.Update(result.log.entries);
  return *end;
}

absl::Status WaitUntilMapped(const Globals& globals, const InterruptGuard& interrupt, ReplayResult& result) {
  const client::Connection connection = ConnectionOf(globals);
  ProgressBar bar(globals, "mapping", result.log.entries, "records");
  TroubleReport trouble(globals);
  const auto start = Clock::now();
  while (!interrupt.interrupted()) {
    const absl::StatusOr<v1::Session> session = client::GetSession(connection, SiteId(globals.site), result.session);
    if (!session.ok() && client::IsPermanent(session.status())) return session.status();
    client::UplinkProgress progress;
    progress.last_error = std::string(session.status().message());
    trouble.Update(progress);
    if (session.ok()) {
      bar.Update(session->mapped_sequence());
      result.mapped = *session;
      result.mapping_s = std::chrono::duration<double>(Clock::now() - start).count();
      if (session->state() == v1::Session::STATE_MAPPED) return absl::OkStatus();
      if (session->state() == v1::Session::STATE_FAILED) {
        return Internal("session {}: mapping failed: {}", result.session.value(), session->error());
      }
    }
    std::this_thread::sleep_for(kPoll);
  }
  return absl::CancelledError(
      fmt::format("interrupted while waiting; the server continues to map: see `enfilade session "
                  "show {}`",
                  result.session.value()));
}

// How to resume a run that was interrupted.
std::string HowToResume(const Globals& globals, const ReplayResult& result) {
  return fmt::format(
      "{} of {} records are acknowledged, and the spool keeps the rest; to resume, repeat the command with --session {}"
      " --spool {} (server {})",
      result.uplink.acknowledged_sequence, result.log.entries, result.session.value(), result.spool_path,
      globals.server);
}

// Deletes what a closed session needs no longer, unless the spool keeps refused records.
absl::Status CleanUp(std::unique_ptr<client::Spool> spool, bool own_file, const ReplayResult& result) {
  ENFILADE_ASSIGN_OR_RETURN(const auto quarantined, spool->ListQuarantined(result.session));
  if (!quarantined.empty()) return absl::OkStatus();
  ENFILADE_RETURN_IF_ERROR(spool->RemoveSession(result.session));
  if (!own_file) return absl::OkStatus();
  spool.reset();
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm", ".lock"}) {
    std::filesystem::remove(result.spool_path + suffix, ignored);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<client::Spool>> OpenSpool(const ReplayOptions& options) {
  client::SpoolOptions spool_options;
  spool_options.max_bytes = std::llround(options.spool_mib * 1024.0 * 1024.0);
  return client::Spool::Open(options.spool, spool_options);
}

// The session that the options and the log mean, as the spool would create it.
absl::StatusOr<client::SpoolSession> SessionOf(const Globals& globals, const ReplayOptions& options,
                                               const CheckedLog& log) {
  client::SpoolSession session;
  session.site = SiteId(globals.site);
  session.id = SessionId(options.session);
  session.robot = RobotId(options.robot);
  session.map = options.map;
  session.source = log.source;
  ENFILADE_ASSIGN_OR_RETURN(session.entry.T_map_robot, EntryOf(options.entry));
  if (session.entry.T_map_robot) session.source += fmt::format(" at={}+-{}", options.entry.at, options.entry.sigma);
  return session;
}

// Brings the rest of the log to the server. CANCELLED: interrupted.
absl::Status SendLog(const Globals& globals, const ReplayOptions& options, client::Spool& spool,
                     const InterruptGuard& interrupt, ReplayResult& result) {
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(options.log, options.reading));
  LogFeeder::Options feeder_options;
  ENFILADE_ASSIGN_OR_RETURN(feeder_options.rate, ParseRate(options.rate));
  LogFeeder feeder(std::move(reader), spool, result.session, feeder_options);
  ENFILADE_RETURN_IF_ERROR(feeder.SkipSpooled());
  const auto start = Clock::now();
  absl::Status sent = Transfer(globals, feeder, spool, interrupt, result);
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  if (sent.ok()) return sent;
  return absl::Status(sent.code(), std::string(sent.message()) + "; " + HowToResume(globals, result));
}

absl::Status RunReplay(const Globals& globals, ReplayOptions options) {
  ENFILADE_RETURN_IF_ERROR(CheckReplay(options));
  ReplayResult result;
  ENFILADE_ASSIGN_OR_RETURN(result.log, CheckLogWithProgress(globals, options));
  if (!globals.json && !globals.quiet) PrintLog(std::cout, options, result.log);
  const bool own_file = options.spool.empty();
  if (own_file) {
    if (options.session.empty()) options.session = NewUuid();
    ENFILADE_ASSIGN_OR_RETURN(options.spool, DefaultSpoolPath("replay-" + options.session));
  }
  ENFILADE_ASSIGN_OR_RETURN(std::unique_ptr<client::Spool> spool, OpenSpool(options));
  result.spool_path = options.spool;
  ENFILADE_ASSIGN_OR_RETURN(const client::SpoolSession wanted, SessionOf(globals, options, result.log));
  ENFILADE_ASSIGN_OR_RETURN(const FoundSession found, FindOrCreateSession(*spool, wanted));
  result.session = found.id;
  result.resumed_after = spool->FindSession(found.id)->acknowledged_sequence;

  const InterruptGuard interrupt;
  ENFILADE_RETURN_IF_ERROR(SendLog(globals, options, *spool, interrupt, result));
  ENFILADE_RETURN_IF_ERROR(CleanUp(std::move(spool), own_file, result));
  if (options.wait) ENFILADE_RETURN_IF_ERROR(WaitUntilMapped(globals, interrupt, result));
  if (globals.json) {
    PrintJson(std::cout, ReplayToJson(options, result));
  } else if (!globals.quiet) {
    PrintReplay(std::cout, options, result);
  }
  return absl::OkStatus();
}

}  // namespace

void AddReplay(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = AddCommand(app, "replay", "Send a recorded log to the server, as a robot would",
                                 [&globals, options] { return RunReplay(globals, *options); });
  command->add_option("LOG", options->log, "CARMEN (.log, .clf, .gz), JSON lines, ...: see docs/logs.md")->required();
  command->add_option("--map", options->map, "The map that it is mapped into, by name or id; created if missing");
  command->add_flag("--record-only", options->record_only, "Only store the records, without mapping them");
  AddEntryOptions(*command, options->entry);
  command->add_option("--robot", options->robot, "The id of the robot that recorded it; created if missing")
      ->capture_default_str();
  command->add_option("--session", options->session, "The session's id: a new one, or the one to resume");
  command->add_option("--spool", options->spool, "The file that keeps records until the server acknowledges them");
  command->add_option("--spool-mib", options->spool_mib, "The largest size of that file, MiB")->capture_default_str();
  command->add_option("--rate", options->rate, "max, real (as recorded) or a factor such as 2.5")
      ->capture_default_str();
  AddNoOdometry(*command, options->reading);
  AddLogOptions(*command, options->reading);
  command->add_flag("--wait", options->wait, "Wait until everything is mapped");
  command->footer(
      "An interrupted run resumes with the same --session and --spool: no record is lost or sent twice.\n"
      "Examples:\n"
      "  enfilade replay intel.clf.gz --map \"Intel lab\" --wait\n"
      "  enfilade replay next.jsonl --map \"Intel lab\" --at 3.2,-1,1.57 --wait\n"
      "  enfilade replay drive.jsonl --map rooms --robot r7 --rate real --session monday --spool r7.spool");
}

}  // namespace enfilade::cli
