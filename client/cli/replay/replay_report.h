// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <ostream>
#include <string>

#include "client/cli/entry_options.h"
#include "client/cli/replay/replay_session.h"
#include "client/sdk/uplink/uplink.h"
#include "core/base/ids.h"
#include "enfilade/v1/session.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

// The command line of `enfilade replay`.
struct ReplayOptions {
  std::string log;
  std::string map;
  bool record_only = false;
  EntryOptions entry;
  std::string robot = "replay";
  std::string session;
  std::string spool;
  double spool_mib = 4096.0;
  std::string rate = "max";
  sources::LogOptions reading;
  bool wait = false;
};

struct ReplayResult {
  CheckedLog log;
  SessionId session;
  std::string spool_path;
  std::int64_t resumed_after = 0;
  double seconds = 0.0;
  client::UplinkProgress uplink;
  std::optional<v1::Session> mapped;  // with --wait
  double mapping_s = 0.0;
};

// The result of a run, for programs and for people.
nlohmann::json ReplayToJson(const ReplayOptions& options, const ReplayResult& result);
void PrintReplay(std::ostream& out, const ReplayOptions& options, const ReplayResult& result);

// The content of the log, before it is sent.
void PrintLog(std::ostream& out, const ReplayOptions& options, const CheckedLog& log);

}  // namespace enfilade::cli
