// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/session_reader.h"

#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

constexpr auto kSurveyTimeout = std::chrono::seconds(60);
constexpr std::int64_t kPortionBytes = 1 << 20;

}  // namespace

storage::CallContext SurveyContext() { return storage::CallContext::WithTimeout(kSurveyTimeout); }

absl::Status SessionReader::ReadRecords(const storage::Session& session, std::optional<TimeNs> until,
                                        const std::function<absl::Status(sensor::Record)>& take) const {
  for (std::int64_t next = 1; next <= session.acknowledged_sequence;) {
    ENFILADE_RETURN_IF_ERROR(proceed_());
    ENFILADE_ASSIGN_OR_RETURN(std::vector<sensor::Record> records,
                              records_.Read(SurveyContext(), site_, session.id, next, kPortionBytes));
    if (records.empty()) break;
    next = records.back().sequence + 1;
    for (sensor::Record& record : records) {
      if (until && sensor::TimeOf(record) > *until) continue;
      ENFILADE_RETURN_IF_ERROR(take(std::move(record)));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<storage::StoredMapping>> SessionReader::LoadMapping(const SessionId& session) const {
  return mappings_.Load(SurveyContext(), site_, session);
}

}  // namespace enfilade::server
