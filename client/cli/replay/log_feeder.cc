// SPDX-License-Identifier: Apache-2.0
#include "client/cli/replay/log_feeder.h"

#include <algorithm>
#include <utility>

#include "client/sources/content.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {

LogFeeder::LogFeeder(sources::LogReader reader, client::Spool& spool, SessionId session, const Options& options)
    : reader_(std::move(reader)), spool_(spool), session_(std::move(session)), options_(options) {}

absl::Status LogFeeder::SkipSpooled() {
  const auto session = spool_.FindSession(session_);
  const std::int64_t spooled = session ? session->last_sequence : 0;
  for (std::int64_t i = 0; i < spooled; ++i) {
    ENFILADE_RETURN_IF_ERROR(ReadNext());
    if (at_end_) {
      return FailedPrecondition("session {} has {} records, but the log has only {}: it is another log",
                                session_.value(), spooled, i);
    }
  }
  return ReadNext();
}

absl::StatusOr<bool> LogFeeder::Feed(Clock::time_point now) {
  if (!next_ && !at_end_) ENFILADE_RETURN_IF_ERROR(ReadNext());
  ENFILADE_RETURN_IF_ERROR(Gather(now));
  if (!gathered_.empty()) ENFILADE_RETURN_IF_ERROR(AppendGathered());
  return next_.has_value() || !gathered_.empty();
}

LogFeeder::Clock::time_point LogFeeder::next_due(Clock::time_point now) const {
  if (!next_ || !options_.rate || !first_time_) return now;
  const double recorded_s = ToSeconds(sensor::TimeOf(next_->payload) - *first_time_);
  return start_ +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(recorded_s / *options_.rate));
}

absl::Status LogFeeder::Gather(Clock::time_point now) {
  std::int64_t bytes = 0;
  while (next_ && gathered_.size() < options_.max_batch && bytes < options_.max_batch_bytes) {
    if (!first_time_) {
      first_time_ = sensor::TimeOf(next_->payload);
      start_ = now;
    }
    if (next_due(now) > now) break;
    client::SpoolItem item{next_->payload, {}};
    if (!next_->content.empty()) {
      ENFILADE_ASSIGN_OR_RETURN(item.content, sources::ReadContent(next_->content));
      bytes += static_cast<std::int64_t>(item.content.size());
    }
    gathered_.push_back(std::move(item));
    ENFILADE_RETURN_IF_ERROR(ReadNext());
  }
  return absl::OkStatus();
}

absl::Status LogFeeder::AppendGathered() {
  spool_is_full_ = false;
  absl::Status whole = spool_.Append(session_, gathered_).status();
  if (whole.ok()) gathered_.clear();
  if (!absl::IsResourceExhausted(whole)) return whole;
  // No room for all: one by one, as far as there is room.
  while (!gathered_.empty()) {
    absl::Status status = spool_.Append(session_, absl::MakeConstSpan(gathered_.data(), 1)).status();
    if (status.ok()) {
      gathered_.erase(gathered_.begin());
    } else if (absl::IsResourceExhausted(status) && spool_.usage().records > 0) {
      spool_is_full_ = true;  // until the server has acknowledged some records
      return absl::OkStatus();
    } else {
      return status;  // even the empty spool has no room for this one
    }
  }
  return absl::OkStatus();
}

absl::Status LogFeeder::ReadNext() {
  ENFILADE_ASSIGN_OR_RETURN(next_, reader_.Next());
  at_end_ = !next_.has_value();
  return absl::OkStatus();
}

}  // namespace enfilade::cli
