// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/call.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/app/runtime/retry_hint.h"
#include "server/rpc/call/request_id.h"
#include "server/rpc/call/site_of.h"
#include "server/rpc/call/status.h"

namespace enfilade::server {
namespace {

constexpr auto kRetryAfter = std::chrono::seconds(1);

using std::chrono::steady_clock;

// The RPCs that may see a site that is being deleted. The store answers CreateSite.
constexpr std::array<std::string_view, 4> kOfDeletedSites = {"CreateSite", "DeleteSite", "GetSite", "ListAuditEntries"};

spdlog::level::level_enum LevelOfFailure(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kCancelled:  // the usual end of a watch
      return spdlog::level::debug;
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kResourceExhausted:
      return spdlog::level::warn;
    default:
      return spdlog::level::info;
  }
}

}  // namespace

Call::Call(const CallEnvironment& environment, const IncomingCall& incoming)
    : environment_(environment),
      rpc_(incoming.rpc),
      request_id_(RequestIdOrNew(incoming.request_id)),
      peer_(incoming.peer),
      principal_(IdentifyPrincipal(incoming.certificate, incoming.actor)),
      client_deadline_(incoming.deadline),
      min_graph_versions_(incoming.min_graph_versions),
      context_{.deadline = client_deadline_.value_or(begin_ + environment.default_timeout),
               .actor = principal_.name,
               .cancellation = cancellation_.get_token()} {}

storage::CallContext Call::StepContext() const {
  storage::CallContext step = context_;
  step.deadline = steady_clock::now() + environment_.default_timeout;
  if (client_deadline_) step.deadline = std::min(step.deadline, *client_deadline_);
  return step;
}

absl::StatusOr<std::int64_t> Call::MinGraphVersion() const {
  std::int64_t minimum = 0;
  for (const std::string& text : min_graph_versions_) {
    const std::size_t separator = text.find('=');
    std::int64_t version = -1;
    const char* const end = text.data() + text.size();
    if (separator != std::string::npos) std::from_chars(text.data() + separator + 1, end, version);
    if (version < 0 || SiteOfName(text.substr(0, separator)).empty()) {
      return InvalidArgument("metadata enfilade-min-graph-version \"{}\": expected sites/SITE=VERSION",
                             Excerpt(text, 100));
    }
    if (SiteOfName(text.substr(0, separator)) == site_) minimum = std::max(minimum, version);
  }
  return minimum;
}

absl::Status Call::CheckAwaited(const storage::CallContext& context) {
  if (context.cancellation.stop_requested()) return absl::CancelledError("the client has cancelled the call");
  if (context.deadline > steady_clock::now()) return absl::OkStatus();
  return absl::DeadlineExceededError("the deadline passed while the call waited for its turn");
}

absl::Status Call::CheckSite() const {
  if (site_.empty() || !environment_.is_being_deleted || !environment_.is_being_deleted(site_)) return absl::OkStatus();
  if (std::find(kOfDeletedSites.begin(), kOfDeletedSites.end(), rpc_) != kOfDeletedSites.end()) return absl::OkStatus();
  return FailedPrecondition("sites/{} is being deleted: GetSite tells its progress", site_);
}

absl::Status Call::CheckAdmitted(const storage::CallContext& context) const {
  ENFILADE_RETURN_IF_ERROR(CheckAwaited(context));
  return CheckSite();
}

absl::Status Call::TooManyCalls() {
  return WithRetryHint(absl::ResourceExhaustedError("too many calls are waiting: try again later"), kRetryAfter);
}

void Call::Finish(const absl::Status& status) const {
  const auto took = steady_clock::now() - begin_;
  environment_.metrics.CountCall(rpc_, status.code(), took);
  const spdlog::level::level_enum level = LevelOfFailure(status.code());
  if (status.ok() || !environment_.logger->should_log(level)) return;
  environment_.logger->log(
      level, fmt::format("{} failed after {} ms: {}: {} (request {}, peer {}, principal \"{}\", site \"{}\")", rpc_,
                         std::chrono::duration_cast<std::chrono::milliseconds>(took).count(),
                         absl::StatusCodeToString(status.code()), BoundedMessage(status), request_id_, peer_,
                         principal_.name, site_));
}

Executor& Call::ExecutorOf(CallLane lane) const {
  Executor* const own = lane == CallLane::kBulk   ? environment_.bulk
                        : lane == CallLane::kSlow ? environment_.slow
                                                  : nullptr;
  return own != nullptr ? *own : environment_.executor;
}

}  // namespace enfilade::server
