// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/spool/spool.h"
#include "client/sources/log_reader.h"

namespace enfilade::cli {

// A log that was read from beginning to end.
struct CheckedLog {
  sources::LogFacts facts;
  sources::LogCounts counts;
  std::int64_t entries = 0;
  std::string source;  // identifies content and options: equal sources, equal records
};

// Reads the whole log once, so that a bad line at its end is found before anything is sent. `on_progress` gets the
// entries read so far. Errors as LogReader's.
absl::StatusOr<CheckedLog> CheckLog(const std::filesystem::path& log, const sources::LogOptions& options,
                                    const std::function<void(std::int64_t)>& on_progress);

// The default path of NAME.spool: in $XDG_STATE_HOME/enfilade, or ~/.local/state/enfilade. Creates the folder.
absl::StatusOr<std::string> DefaultSpoolPath(const std::string& name);

struct FoundSession {
  SessionId id;
  bool resumed = false;
};

// The session of `spool` to resume, or a new one. If `wanted.id` is empty, it resumes an unfinished replay of the same
// log into the same map, or gets a new id. FAILED_PRECONDITION: that session is of another log, map, robot or site.
absl::StatusOr<FoundSession> FindOrCreateSession(client::Spool& spool, const client::SpoolSession& wanted);

}  // namespace enfilade::cli
