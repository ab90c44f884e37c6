// SPDX-License-Identifier: Apache-2.0
#include "client/robot/run.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "client/robot/commands.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::robot {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kCommandPoll = std::chrono::milliseconds(100);

Clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// When a record is due, at the pace of the records' times.
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
  // After a pause: from here on anew.
  void Reset() { first_.reset(); }

 private:
  std::optional<double> rate_;
  std::optional<TimeNs> first_;
  Clock::time_point start_;
};

class Runner {
 public:
  Runner(Agent& agent, Uploader& uploader, Source& source, LineInput* commands, const RunOptions& options,
         const std::function<bool()>& interrupted, const NewsListener& listener)
      : agent_(agent),
        uploader_(uploader),
        source_(source),
        commands_(commands),
        options_(options),
        interrupted_(interrupted),
        listener_(listener),
        pace_(options.rate),
        next_status_(Clock::now() + Seconds(options.status_s)) {}

  absl::Status Record() {
    ENFILADE_RETURN_IF_ERROR(agent_.Start());
    while (agent_.state() != State::kEnd) {
      if (interrupted_()) {
        ENFILADE_RETURN_IF_ERROR(agent_.Do(Abort{}));
        return absl::CancelledError("interrupted");
      }
      ENFILADE_RETURN_IF_ERROR(TellStatus());
      const bool menu = agent_.state() == State::kMainMenu;
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
    while (!uploader_.Done(options_.wait)) {
      if (interrupted_()) return absl::CancelledError("interrupted");
      const Uploader::Progress progress = uploader_.progress();
      if (!progress.blocked.empty()) return FailedPrecondition("{}", progress.blocked);
      ENFILADE_RETURN_IF_ERROR(TellStatus());
      std::this_thread::sleep_for(kCommandPoll);
    }
    return absl::OkStatus();
  }

 private:
  absl::Status TellStatus() {
    if (Clock::now() < next_status_) return absl::OkStatus();
    next_status_ = Clock::now() + Seconds(options_.status_s);
    return agent_.Do(AskStatus{});
  }

  absl::Status TakeCommand(std::chrono::milliseconds patience) {
    if (!commands_ || commands_->at_end()) {
      // Nobody is there to choose from the menu.
      return patience.count() > 0 ? agent_.Do(Abort{}) : absl::OkStatus();
    }
    const absl::StatusOr<std::optional<std::string>> line = commands_->Next(patience);
    if (!line.ok() && !absl::IsInvalidArgument(line.status())) return line.status();
    if (line.ok() && (!line->has_value() || (*line)->find_first_not_of(" \t") == std::string::npos)) {
      return absl::OkStatus();
    }
    const absl::StatusOr<Command> command =
        line.ok() ? ParseCommand(**line, options_.pose_covariance) : absl::StatusOr<Command>(line.status());
    if (command.ok()) return agent_.Do(*command);
    TellBadInput(std::string(command.status().message()));
    return absl::OkStatus();
  }

  absl::Status TakeInput() {
    if (!waiting_) {
      ENFILADE_ASSIGN_OR_RETURN(waiting_, source_.Next());
    }
    if (const auto* item = std::get_if<client::SpoolItem>(&*waiting_)) {
      const auto now = Clock::now();
      const auto due = pace_.DueOf(TimeOf(*item), now);
      if (due > now) {
        std::this_thread::sleep_for(std::min<Clock::duration>(due - now, kCommandPoll));
        return agent_.Flush();
      }
    }
    const Input input = *std::exchange(waiting_, std::nullopt);
    return std::visit([this](const auto& one) { return Take(one); }, input);
  }

  absl::Status Take(const client::SpoolItem& item) { return agent_.Add(item); }
  absl::Status Take(const Command& command) { return agent_.Do(command); }
  absl::Status Take(const BadInput& bad) {
    TellBadInput(bad.message);
    return absl::OkStatus();
  }
  absl::Status Take(const Idle&) { return agent_.Flush(); }
  absl::Status Take(const Ended&) { return agent_.Finish(); }
  absl::Status Take(const OwnPose& pose) {
    agent_.ReportPose(pose);
    return absl::OkStatus();
  }

  void TellBadInput(const std::string& message) { listener_({"bad_input", message, {{"error", message}}}); }

  Agent& agent_;
  Uploader& uploader_;
  Source& source_;
  LineInput* const commands_;
  const RunOptions& options_;
  const std::function<bool()>& interrupted_;
  const NewsListener& listener_;
  Pace pace_;
  Clock::time_point next_status_;
  std::optional<Input> waiting_;  // taken from the source, not due yet
};

}  // namespace

absl::Status Run(Agent& agent, Uploader& uploader, Source& source, LineInput* commands, const RunOptions& options,
                 const std::function<bool()>& interrupted, const NewsListener& listener) {
  Runner runner(agent, uploader, source, commands, options, interrupted, listener);
  const absl::Status recorded = runner.Record();
  if (!recorded.ok() && !absl::IsCancelled(recorded)) {
    // What came before the trouble is worth as much as ever.
    agent.Do(Abort{}).IgnoreError();
  }
  if (absl::IsCancelled(recorded)) return recorded;
  const absl::Status uploaded = runner.Upload();
  return recorded.ok() ? uploaded : recorded;
}

}  // namespace enfilade::robot
