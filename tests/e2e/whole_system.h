// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tests/support/cluster.h"
#include "tests/support/database.h"
#include "tests/support/process.h"
#include "tests/support/server_process.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {

// How `enfilade replay` is called.
struct Replay {
  std::string site;
  std::string session = "drive";
  std::string map = "Rooms";
  std::string rate = "max";
  bool wait = true;
};

// Database, server and a recorded drive in one temporary directory.
class WholeSystem {
 public:
  // On a TestDatabase, which may be in a server that others use.
  explicit WholeSystem(std::vector<std::string> server_settings);
  // On a cluster of its own, which the test may kill.
  WholeSystem(Cluster::Durability durability, std::vector<std::string> server_settings);

  ServerProcess& server() { return server_; }
  const std::filesystem::path& directory() const { return directory_.path(); }
  // Of a cluster of its own: kill -9 of the postmaster. Throws if none is running.
  void KillDatabase();
  void RestartDatabase();
  // Another server on the same database, not yet started.
  std::unique_ptr<ServerProcess> AnotherServer(const std::string& name) const;

  // Runs `enfilade ARGUMENTS` against the server; throws if it fails.
  void Tool(const std::string& site, const std::vector<std::string>& arguments) const;
  void CreateSite(const std::string& site) const;
  // Simulates a drive of `laps` laps for later replays.
  void RecordDrive(int laps);
  // Starts a replay against `server`. The same site and session use the same spool, so that it continues where it was.
  std::unique_ptr<Process> StartReplay(const Replay& replay, const ServerProcess& server) const;
  std::filesystem::path ReplayLog(const Replay& replay) const;
  // The highest sequence in the robot's spool; 0 if there is none.
  std::int64_t SpooledSequence(const Replay& replay) const;

  // The first column of all rows, as text; nullopt if the database does not answer.
  std::optional<std::vector<std::string>> TryQuery(const std::string& sql) const;
  // Its first value; throws if there is none.
  std::string Query(const std::string& sql) const;
  // Of the site's session; 0 if the database does not answer or has none.
  std::int64_t AcknowledgedSequence(const std::string& site) const;
  std::int64_t MappedSequence(const std::string& site) const;

  // The files of the map "Rooms" and the session's trajectory, by name.
  std::vector<std::pair<std::string, std::string>> ExportAll(const std::string& site) const;

 private:
  const std::string& database_url() const;
  Cluster& own_cluster();
  std::int64_t NumberOf(const std::string& sql) const;
  std::filesystem::path SpoolOf(const Replay& replay) const;

  TemporaryDirectory directory_;
  std::variant<Cluster, TestDatabase> database_;
  std::vector<std::string> settings_;
  ServerProcess server_;
};

}  // namespace enfilade::testing
