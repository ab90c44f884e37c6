// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/session/replay.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "client/cli/interrupt.h"
#include "client/cli/log_options.h"
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

constexpr auto kLookRound = std::chrono::milliseconds(100);

absl::StatusOr<std::optional<double>> RateOf(const std::string& text) {
  if (text == "max") return std::nullopt;
  if (text == "real") return 1.0;
  char* end = nullptr;
  const double rate = std::strtod(text.c_str(), &end);
  if (end != text.c_str() && *end == '\0' && std::isfinite(rate) && rate > 0.0) return rate;
  return InvalidArgument("--rate is \"{}\": expected max, real or a factor such as 2.5", text);
}

absl::Status CheckReplay(const ReplayOptions& options) {
  if (options.map.empty() == !options.record_only) {
    return InvalidArgument("say with --map which map the log goes into, or --record-only");
  }
  ENFILADE_RETURN_IF_ERROR(EntryOf(options.entry).status());
  if (!options.entry.at.empty() && options.record_only) {
    return InvalidArgument("--at says where in a map the log begins: it does not go with --record-only");
  }
  if (!IsValidResourceId(options.robot)) {
    return InvalidArgument("--robot is \"{}\": expected 1 to 63 of a-z, 0-9 and \"-\"", options.robot);
  }
  if (!options.session.empty() && !IsValidResourceId(options.session)) {
    return InvalidArgument("--session is \"{}\": expected 1 to 63 of a-z, 0-9 and \"-\"", options.session);
  }
  if (!(options.spool_mib >= 1.0)) return InvalidArgument("--spool-mib is {}: expected 1 or more", options.spool_mib);
  return RateOf(options.rate).status();
}

absl::StatusOr<CheckedLog> CheckLogWithProgress(const Globals& globals, const ReplayOptions& options) {
  ProgressBar bar(globals, "checking", 0, "entries");
  return CheckLog(options.log, options.reading, [&](std::int64_t entries) { bar.Update(entries); });
}

// Tells once why the server does not take records, and that nothing is lost.
class TroubleReport {
 public:
  explicit TroubleReport(const Globals& globals) : shown_(!globals.quiet) {}

  void Update(const client::UplinkProgress& progress) {
    if (progress.last_error == last_) return;
    last_ = progress.last_error;
    if (shown_ && !last_.empty()) {
      std::cerr << "\nenfilade: " << last_ << "; trying again (nothing is lost; Ctrl-C stops)" << std::endl;
    }
  }

 private:
  bool shown_;
  std::string last_;
};

// Feeds the spool and waits until the uplink has brought everything over.
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
        spool.WaitForSpace(1 << 20, now + kLookRound);
      } else if (const auto due = feeder.next_due(now); feeding && due > now) {
        std::this_thread::sleep_until(std::min<Clock::time_point>(due, now + kLookRound));
      }
    } else {
      end = uplink.WaitFor(kLookRound);
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
        return Internal("session {}: mapping has stopped: {}", result.session.value(), session->error());
      }
    }
    std::this_thread::sleep_for(kLookRound);
  }
  return absl::CancelledError(
      fmt::format("interrupted while waiting; the server goes on mapping: see `enfilade session "
                  "show {}`",
                  result.session.value()));
}

// What to type to go on after a run that was broken off.
std::string HowToGoOn(const Globals& globals, const ReplayResult& result) {
  return fmt::format(
      "{} of {} records are acknowledged, the rest is kept; go on with the same command and --session {}"
      " --spool {} (server {})",
      result.uplink.acknowledged_sequence, result.log.entries, result.session.value(), result.spool_path,
      globals.server);
}

// A session that is closed needs its spool no more, unless refused records are kept in it.
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
  client::SpoolOptions spool_options;
  spool_options.max_bytes = std::llround(options.spool_mib * 1024.0 * 1024.0);
  ENFILADE_ASSIGN_OR_RETURN(std::unique_ptr<client::Spool> spool, client::Spool::Open(options.spool, spool_options));
  result.spool_path = options.spool;

  client::SpoolSession wanted;
  wanted.site = SiteId(globals.site);
  wanted.id = SessionId(options.session);
  wanted.robot = RobotId(options.robot);
  wanted.map = options.map;
  wanted.source = result.log.source;
  ENFILADE_ASSIGN_OR_RETURN(wanted.entry.T_map_robot, EntryOf(options.entry));
  if (wanted.entry.T_map_robot) wanted.source += fmt::format(" at={}+-{}", options.entry.at, options.entry.sigma);
  ENFILADE_ASSIGN_OR_RETURN(const FoundSession found, FindOrCreateSession(*spool, wanted));
  result.session = found.id;
  result.resumed_after = spool->FindSession(found.id)->acknowledged_sequence;

  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(options.log, options.reading));
  LogFeeder::Options feeder_options;
  ENFILADE_ASSIGN_OR_RETURN(feeder_options.rate, RateOf(options.rate));
  LogFeeder feeder(std::move(reader), *spool, result.session, feeder_options);
  ENFILADE_RETURN_IF_ERROR(feeder.SkipSpooled());

  const InterruptGuard interrupt;
  const auto start = Clock::now();
  const absl::Status transferred = Transfer(globals, feeder, *spool, interrupt, result);
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  if (!transferred.ok()) {
    return absl::Status(transferred.code(), std::string(transferred.message()) + "; " + HowToGoOn(globals, result));
  }
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
  CLI::App* command = AddCommand(app, "replay", "Bring a recorded log to the server as a robot would",
                                 [&globals, options] { return RunReplay(globals, *options); });
  command->add_option("LOG", options->log, "CARMEN (.log, .clf, .gz), JSON lines, ...: see docs/logs.md")->required();
  command->add_option("--map", options->map, "The map that it goes into, by name or id; created where missing");
  command->add_flag("--record-only", options->record_only, "Into no map: only store the records");
  AddEntryOptions(*command, options->entry);
  command->add_option("--robot", options->robot, "Who has recorded it; created where missing")->capture_default_str();
  command->add_option("--session", options->session, "The session's id: to choose it, or to go on with it");
  command->add_option("--spool", options->spool, "The file that keeps what is not acknowledged yet");
  command->add_option("--spool-mib", options->spool_mib, "The most that it may keep, MiB")->capture_default_str();
  command->add_option("--rate", options->rate, "max, real (as recorded) or a factor such as 2.5")
      ->capture_default_str();
  AddNoOdometry(*command, options->reading);
  AddLogOptions(*command, options->reading);
  command->add_flag("--wait", options->wait, "Wait until all of it is mapped");
  command->footer(
      "A run that was broken off goes on where it was with the same --session and --spool: nothing is lost or "
      "doubled.\n"
      "Examples:\n"
      "  enfilade replay intel.clf.gz --map \"Intel lab\" --wait\n"
      "  enfilade replay next.jsonl --map \"Intel lab\" --at 3.2,-1,1.57 --wait\n"
      "  enfilade replay drive.jsonl --map rooms --robot r7 --rate real --session monday --spool r7.spool");
}

}  // namespace enfilade::cli
