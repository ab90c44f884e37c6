// SPDX-License-Identifier: Apache-2.0
#include "client/robot/run.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "client/robot/input/commands.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::robot {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kCommandPoll = std::chrono::milliseconds(100);

Clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// When records are due, so that they are replayed at a multiple of the speed at which they were recorded.
class Pace {
 public:
  explicit Pace(std::optional<double> rate) : rate_(rate) {}

  Clock::time_point DueOf(TimeNs time, Clock::time_point now) {
    if (!rate_) return now;
    if (!first_) {
      first_ = time;
      start_ = now;
    }
    return start_ + Seconds(ToSeconds(time - *first_) / *rate_);
  }
  // After a pause: the next record is due immediately.
  void Reset() { first_.reset(); }

 private:
  std::optional<double> rate_;
  std::optional<TimeNs> first_;
  Clock::time_point start_;
};

class Runner {
 public:
  Runner(const RunContext& context, const RunOptions& options)
      : context_(context),
        options_(options),
        pace_(options.rate),
        next_status_(Clock::now() + Seconds(options.status_s)) {}

  absl::Status Record() {
    ENFILADE_RETURN_IF_ERROR(context_.agent.Start());
    while (context_.agent.state() != State::kEnd) {
      if (context_.interrupted()) {
        ENFILADE_RETURN_IF_ERROR(context_.agent.Do(Abort{}));
        return absl::CancelledError("interrupted");
      }
      ENFILADE_RETURN_IF_ERROR(ShowStatusWhenDue());
      const bool menu = context_.agent.state() == State::kMainMenu;
      ENFILADE_RETURN_IF_ERROR(TakeCommand(menu && !options_.live ? kCommandPoll : std::chrono::milliseconds(0)));
      if (menu && !options_.live) {
        pace_.Reset();
        continue;
      }
      ENFILADE_RETURN_IF_ERROR(TakeInput());
    }
    return absl::OkStatus();
  }

  absl::Status Upload() {
    while (!context_.uploader.Done(options_.wait)) {
      if (context_.interrupted()) return absl::CancelledError("interrupted");
      const Uploader::Progress progress = context_.uploader.progress();
      if (!progress.blocked.empty()) return FailedPrecondition("{}", progress.blocked);
      ENFILADE_RETURN_IF_ERROR(ShowStatusWhenDue());
      std::this_thread::sleep_for(kCommandPoll);
    }
    return absl::OkStatus();
  }

 private:
  absl::Status ShowStatusWhenDue() {
    if (Clock::now() < next_status_) return absl::OkStatus();
    next_status_ = Clock::now() + Seconds(options_.status_s);
    return context_.agent.Do(AskStatus{});
  }

  absl::Status TakeCommand(std::chrono::milliseconds timeout) {
    if (!context_.commands || context_.commands->at_end()) {
      // In the main menu, nobody can choose.
      return timeout.count() > 0 ? context_.agent.Do(Abort{}) : absl::OkStatus();
    }
    const absl::StatusOr<std::optional<std::string>> line = context_.commands->Next(timeout);
    if (!line.ok() && !absl::IsInvalidArgument(line.status())) return line.status();
    if (line.ok() && (!line->has_value() || (*line)->find_first_not_of(" \t") == std::string::npos)) {
      return absl::OkStatus();
    }
    const absl::StatusOr<Command> command =
        line.ok() ? ParseCommand(**line, options_.pose_covariance) : absl::StatusOr<Command>(line.status());
    if (command.ok()) return context_.agent.Do(*command);
    NotifyBadInput(std::string(command.status().message()));
    return absl::OkStatus();
  }

  absl::Status TakeInput() {
    if (!waiting_) {
      ENFILADE_ASSIGN_OR_RETURN(waiting_, context_.source.Next());
    }
    if (const auto* item = std::get_if<client::SpoolItem>(&*waiting_)) {
      const auto now = Clock::now();
      const auto due = pace_.DueOf(TimeOf(*item), now);
      if (due > now) {
        std::this_thread::sleep_for(std::min<Clock::duration>(due - now, kCommandPoll));
        return context_.agent.Flush();
      }
    }
    const Input input = *std::exchange(waiting_, std::nullopt);
    return std::visit([this](const auto& one) { return Take(one); }, input);
  }

  absl::Status Take(const client::SpoolItem& item) { return context_.agent.Add(item); }
  absl::Status Take(const Command& command) { return context_.agent.Do(command); }
  absl::Status Take(const BadInput& bad) {
    NotifyBadInput(bad.message);
    return absl::OkStatus();
  }
  absl::Status Take(const Idle&) { return context_.agent.Flush(); }
  absl::Status Take(const Ended&) { return context_.agent.Finish(); }
  absl::Status Take(const PoseReport& pose) {
    context_.agent.ReportPose(pose);
    return absl::OkStatus();
  }

  void NotifyBadInput(const std::string& message) { context_.listener({"bad_input", message, {{"error", message}}}); }

  const RunContext& context_;
  const RunOptions& options_;
  Pace pace_;
  Clock::time_point next_status_;
  std::optional<Input> waiting_;  // read from the source, not due yet
};

}  // namespace

absl::Status Run(const RunContext& context, const RunOptions& options) {
  Runner runner(context, options);
  absl::Status recorded = runner.Record();
  if (!recorded.ok() && !absl::IsCancelled(recorded)) {
    // What was recorded before the error is kept.
    context.agent.Do(Abort{}).IgnoreError();
  }
  if (absl::IsCancelled(recorded)) return recorded;
  const absl::Status uploaded = runner.Upload();
  return recorded.ok() ? uploaded : recorded;
}

}  // namespace enfilade::robot
