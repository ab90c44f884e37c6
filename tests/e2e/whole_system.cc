// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/whole_system.h"

#include <libpq-fe.h>
#include <signal.h>
#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/support/command.h"
#include "tests/support/eventually.h"

namespace enfilade::testing {
namespace {

namespace fs = std::filesystem;

std::string ReadAll(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

WholeSystem::WholeSystem(Cluster::Durability durability, std::vector<std::string> server_settings)
    : database_(std::in_place_type<Cluster>, durability),
      settings_(std::move(server_settings)),
      server_(directory_.path(), "server", database_url(), settings_) {
  const CommandResult migrate = RunCommand({ProjectFile("deploy/database/migrate"), "up", database_url()});
  if (migrate.exit_code != 0) throw std::runtime_error("the migrations failed:\n" + migrate.output);
  server_.StartAndWait();
}

WholeSystem::WholeSystem(std::vector<std::string> server_settings)
    : database_(std::in_place_type<TestDatabase>),
      settings_(std::move(server_settings)),
      server_(directory_.path(), "server", database_url(), settings_) {
  server_.StartAndWait();
}

const std::string& WholeSystem::database_url() const {
  return std::visit([](const auto& database) -> const std::string& { return database.url(); }, database_);
}

Cluster& WholeSystem::own_cluster() {
  Cluster* cluster = std::get_if<Cluster>(&database_);
  if (!cluster) throw std::logic_error("others may use this database's server");
  return *cluster;
}

void WholeSystem::RestartDatabase() { own_cluster().Restart(); }

void WholeSystem::KillDatabase() {
  const pid_t postmaster = own_cluster().pid();
  if (postmaster <= 1) throw std::runtime_error("no database is running");  // 0 would be this test's own group
  kill(postmaster, SIGKILL);
  // Until it is gone, not only dying, PostgreSQL refuses to start again.
  if (!Eventually([&] { return kill(postmaster, 0) != 0; })) throw std::runtime_error("the database does not die");
}

std::unique_ptr<ServerProcess> WholeSystem::AnotherServer(const std::string& name) const {
  return std::make_unique<ServerProcess>(directory_.path(), name, database_url(), settings_);
}

void WholeSystem::Tool(const std::string& site, const std::vector<std::string>& arguments) const {
  std::vector<std::string> command = {Program("enfilade"), "--quiet", "--server", server_.address(), "--site", site};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const CommandResult result = RunCommand(command);
  if (result.exit_code != 0) throw std::runtime_error("enfilade " + arguments[0] + ": " + result.output);
}

void WholeSystem::CreateSite(const std::string& site) const { Tool(site, {"site", "create", site}); }

void WholeSystem::RecordDrive(int laps) {
  Tool("none", {"simulate", "-o", (directory() / "drive.jsonl").string(), "--laps", std::to_string(laps)});
}

std::unique_ptr<Process> WholeSystem::StartReplay(const Replay& replay, const ServerProcess& server) const {
  std::vector<std::string> command = {Program("enfilade"),
                                      "--quiet",
                                      "--server",
                                      server.address(),
                                      "--site",
                                      replay.site,
                                      "replay",
                                      (directory() / "drive.jsonl").string(),
                                      "--map",
                                      replay.map,
                                      "--session",
                                      replay.session,
                                      "--spool",
                                      SpoolOf(replay).string(),
                                      "--rate",
                                      replay.rate};
  if (replay.wait) command.emplace_back("--wait");
  return std::make_unique<Process>(command, ReplayLog(replay));
}

fs::path WholeSystem::ReplayLog(const Replay& replay) const {
  return directory() / (replay.site + "-" + replay.session + ".log");
}

fs::path WholeSystem::SpoolOf(const Replay& replay) const {
  return directory() / (replay.site + "-" + replay.session + ".spool");
}

std::int64_t WholeSystem::SpooledSequence(const Replay& replay) const {
  sqlite3* database = nullptr;
  sqlite3_stmt* statement = nullptr;
  std::int64_t sequence = 0;
  if (sqlite3_open_v2(SpoolOf(replay).c_str(), &database, SQLITE_OPEN_READWRITE, nullptr) == SQLITE_OK &&
      sqlite3_prepare_v2(database, "SELECT max(last_sequence) FROM sessions", -1, &statement, nullptr) == SQLITE_OK &&
      sqlite3_step(statement) == SQLITE_ROW) {
    sequence = sqlite3_column_int64(statement, 0);
  }
  sqlite3_finalize(statement);
  sqlite3_close(database);
  return sequence;
}

std::optional<std::vector<std::string>> WholeSystem::TryQuery(const std::string& sql) const {
  const std::unique_ptr<PGconn, void (*)(PGconn*)> connection(PQconnectdb(database_url().c_str()), PQfinish);
  PQclear(PQexec(connection.get(), "SET search_path = enfilade, public"));
  const std::unique_ptr<PGresult, void (*)(PGresult*)> result(PQexec(connection.get(), sql.c_str()), PQclear);
  if (PQresultStatus(result.get()) != PGRES_TUPLES_OK) return std::nullopt;
  std::vector<std::string> values;
  for (int i = 0; i < PQntuples(result.get()); ++i) values.emplace_back(PQgetvalue(result.get(), i, 0));
  return values;
}

std::string WholeSystem::Query(const std::string& sql) const {
  const auto values = TryQuery(sql);
  if (!values || values->empty()) throw std::runtime_error("no answer to: " + sql);
  return values->front();
}

std::int64_t WholeSystem::NumberOf(const std::string& sql) const {
  const auto values = TryQuery(sql);
  return values && !values->empty() ? std::stoll(values->front()) : 0;
}

std::int64_t WholeSystem::AcknowledgedSequence(const std::string& site) const {
  return NumberOf("SELECT acknowledged_sequence FROM sessions WHERE site_id = '" + site + "'");
}

std::int64_t WholeSystem::MappedSequence(const std::string& site) const {
  return NumberOf("SELECT mapped_sequence FROM mapping_checkpoints WHERE site_id = '" + site + "'");
}

std::vector<std::pair<std::string, std::string>> WholeSystem::ExportAll(const std::string& site) const {
  const fs::path out = directory() / ("export-" + site);
  fs::create_directories(out);
  Tool(site, {"map", "export", "Rooms", "-o", out.string(), "--format", "pgm"});
  Tool(site, {"trajectory", "export", "drive", "-o", (out / "trajectory.txt").string()});
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : fs::directory_iterator(out)) {
    files.emplace_back(entry.path().filename().string(), ReadAll(entry.path()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace enfilade::testing
