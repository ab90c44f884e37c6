// SPDX-License-Identifier: Apache-2.0
#include "client/cli/replay/replay_session.h"

#include <array>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"

namespace enfilade::cli {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<std::string> HashOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return NotFound("{}: cannot be read", path.string());
  Sha256Stream hash;
  std::array<char, 65536> buffer{};
  while (file.read(buffer.data(), buffer.size()) || file.gcount() > 0) {
    hash.Add({buffer.data(), static_cast<std::size_t>(file.gcount())});
  }
  return ToHex(hash.Finish());
}

std::string SourceOf(const std::string& hash, const sources::LogOptions& options) {
  std::string source = "log sha256:" + hash;
  if (!options.odometry) source += " no-odometry";
  if (options.skip_bad_lines) source += " skip-bad-lines";
  if (options.range_max) source += fmt::format(" range-max={}", *options.range_max);
  if (options.field_of_view) source += fmt::format(" fov={}", *options.field_of_view);
  return source;
}

bool IsSameRecording(const client::SpoolSession& a, const client::SpoolSession& b) {
  return a.site == b.site && a.robot == b.robot && a.map == b.map && a.source == b.source;
}

}  // namespace

absl::StatusOr<CheckedLog> CheckLog(const fs::path& log, const sources::LogOptions& options,
                                    const std::function<void(std::int64_t)>& on_progress) {
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(log, options));
  CheckedLog checked;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const auto entry, reader.Next());
    if (!entry) break;
    on_progress(++checked.entries);
  }
  if (checked.entries == 0) return InvalidArgument("{}: the log has no entries to record", log.string());
  checked.facts = reader.facts();
  checked.counts = reader.counts();
  ENFILADE_ASSIGN_OR_RETURN(const std::string hash, HashOf(log));
  checked.source = SourceOf(hash, options);
  return checked;
}

absl::StatusOr<std::string> DefaultSpoolPath(const std::string& name) {
  const char* state = std::getenv("XDG_STATE_HOME");
  const char* home = std::getenv("HOME");
  fs::path folder;
  if (state && *state) {
    folder = state;
  } else if (home && *home) {
    folder = fs::path(home) / ".local/state";
  } else {
    return FailedPrecondition("neither XDG_STATE_HOME nor HOME is set: give the spool's file by --spool");
  }
  folder /= "enfilade";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return FailedPrecondition("{}: cannot be created ({}): give the spool's file by --spool", folder.string(),
                              error.message());
  }
  return (folder / (name + ".spool")).string();
}

absl::StatusOr<FoundSession> FindOrCreateSession(client::Spool& spool, const client::SpoolSession& wanted) {
  if (!wanted.id.empty()) {
    if (const auto found = spool.FindSession(wanted.id)) {
      if (IsSameRecording(*found, wanted)) return FoundSession{found->id, true};
      return FailedPrecondition(
          "{}: session {} is by robot \"{}\" into map \"{}\" of site \"{}\" from {}: it can be resumed only with the "
          "same "
          "log, map, robot and options",
          spool.path(), found->id.value(), found->robot.value(), found->map, found->site.value(), found->source);
    }
  } else {
    for (const client::SpoolSession& session : spool.ListSessions()) {
      if (!session.closed && IsSameRecording(session, wanted)) return FoundSession{session.id, true};
    }
  }
  client::SpoolSession fresh = wanted;
  if (fresh.id.empty()) fresh.id = SessionId(NewUuid());
  fresh.request_id = NewUuid();
  ENFILADE_RETURN_IF_ERROR(spool.CreateSession(fresh));
  return FoundSession{fresh.id, false};
}

}  // namespace enfilade::cli
