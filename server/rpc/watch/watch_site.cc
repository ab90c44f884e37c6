// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/watch/watch_site.h"

#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/version.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/app/watch/site_looks.h"
#include "server/app/watch/site_updates.h"
#include "server/rpc/watch/messages.h"
#include "server/rpc/watch/resume_token.h"

namespace enfilade::server {
namespace {

using WatchClock = std::chrono::steady_clock;

constexpr double kMinWatchRate = 0.2;
constexpr double kMaxWatchRate = 20.0;
constexpr auto kMaxSilence = std::chrono::seconds(10);
// Sessions that have ended while nobody watched. If there were more, the last ones are told.
constexpr int kMaxEnded = 1000;

struct SiteWatch {
  SiteId site;
  v1::RobotView view = v1::ROBOT_VIEW_BASIC;
  WatchClock::duration period = {};
  SiteUpdates updates;
  PoseLooks::Watcher watcher;
  std::int64_t min_graph_version = 0;                  // that the first message must have
  std::shared_ptr<const SiteMoment> moment = nullptr;  // of the last look
  SiteMessages messages = {};
  WatchClock::time_point sent = {};
  bool first = true;

  // Whether a message is due even if there is nothing to tell.
  bool is_silent() const { return first || WatchClock::now() + period >= sent + kMaxSilence; }
};

absl::StatusOr<WatchClock::duration> WatchPeriodOf(double rate_hz) {
  const double rate = rate_hz == 0.0 ? 2.0 : rate_hz;
  if (!(rate >= kMinWatchRate && rate <= kMaxWatchRate)) {
    return InvalidArgument("rate_hz is {}: it must lie in [{}, {}]", rate_hz, kMinWatchRate, kMaxWatchRate);
  }
  return std::chrono::duration_cast<WatchClock::duration>(std::chrono::duration<double>(1.0 / rate));
}

absl::StatusOr<v1::RobotView> RobotViewOf(v1::RobotView view) {
  if (!v1::RobotView_IsValid(view)) return InvalidArgument("view is {}: not one of RobotView", static_cast<int>(view));
  return view == v1::ROBOT_VIEW_UNSPECIFIED ? v1::ROBOT_VIEW_BASIC : view;
}

void LookAtSite(const Services& services, const std::shared_ptr<SiteWatch>& watch, WatchClock::time_point deadline,
                const std::function<void(const absl::StatusOr<bool>&)>& then) {
  const auto look = [&services, watch, then](const absl::Status& ready) {
    if (!ready.ok()) return then(ready);
    services.site_looks.Look(watch->site, [watch, then](const SiteLooks::Result& moment) {
      if (!moment.ok()) return then(moment.status());
      if ((*moment)->graph->version() < watch->min_graph_version) return then(false);  // a look of just before
      watch->min_graph_version = 0;
      const bool is_new = std::exchange(watch->moment, *moment) != *moment;
      then(is_new || watch->is_silent());
    });
  };
  if (watch->min_graph_version == 0) return look(absl::OkStatus());
  services.graph_waits.Await(watch->site, watch->min_graph_version, deadline, look);
}

absl::StatusOr<bool> Tell(const Services& services, const storage::CallContext& context, SiteWatch& watch,
                          v1::WatchSiteResponse& response) {
  response.Clear();
  if (watch.messages.done()) {
    const auto read_past = [&](TimeNs since, TimeNs finished_since) {
      return services.activity.ReadPast(context, watch.site, since, finished_since, kMaxEnded);
    };
    ENFILADE_ASSIGN_OR_RETURN(SiteUpdate update, watch.updates.Next(watch.moment, read_past));
    if (update.empty() && !watch.is_silent()) return false;
    if (std::exchange(watch.first, false)) {
      response.mutable_start()->set_server_version(kVersion);
      response.mutable_start()->set_reset(update.reset);
    }
    watch.messages = SiteMessages(watch.site, watch.view, std::move(update));
  }
  watch.messages.Next(response);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  *response.mutable_send_time() =
      convert::ToTimestamp(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
  if (watch.messages.done()) response.set_resume_token(ToResumeToken(watch.updates.position()));
  watch.sent = WatchClock::now();
  return true;
}

}  // namespace

absl::StatusOr<Watch<v1::WatchSiteResponse>> WatchSite(const Services& services, const Call& call,
                                                       const v1::WatchSiteRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const v1::RobotView view, RobotViewOf(request.view()));
  ENFILADE_ASSIGN_OR_RETURN(const auto period, WatchPeriodOf(request.rate_hz()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t minimum, call.MinGraphVersion());
  ENFILADE_ASSIGN_OR_RETURN(PoseLooks::Watcher watcher, services.site_looks.Admit(site));
  const std::set<int> levels(request.levels().begin(), request.levels().end());
  const auto watch = std::make_shared<SiteWatch>(SiteWatch{.site = std::move(site),
                                                           .view = view,
                                                           .period = period,
                                                           .updates = {ParseWatchToken(request.resume_token()), levels},
                                                           .watcher = std::move(watcher),
                                                           .min_graph_version = minimum});
  return Watch<v1::WatchSiteResponse>{
      .period = period,
      .look =
          [&services, watch, &call](const std::function<void(const absl::StatusOr<bool>&)>& then) {
            LookAtSite(services, watch, call.StepContext().deadline, then);
          },
      .check = [&services, watch](const storage::CallContext& context, v1::WatchSiteResponse& message)
          -> absl::StatusOr<bool> { return Tell(services, context, *watch, message); },
      .has_more = [watch] { return !watch->messages.done(); },
      .stopping = [&services] { return services.graphs.stopping(); }};
}

}  // namespace enfilade::server
