// SPDX-License-Identifier: Apache-2.0
#include "tests/support/database.h"

#include <libpq-fe.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <stdexcept>

#include "tests/support/cluster.h"
#include "tests/support/command.h"

namespace enfilade::testing {
namespace {

struct Finish {
  void operator()(PGconn* connection) const { PQfinish(connection); }
};

std::vector<std::string> Execute(const std::string& url, const std::string& sql) {
  const std::unique_ptr<PGconn, Finish> connection(PQconnectdb(url.c_str()));
  const std::unique_ptr<PGresult, void (*)(PGresult*)> result(PQexec(connection.get(), sql.c_str()), PQclear);
  const ExecStatusType status = PQresultStatus(result.get());
  if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) {
    throw std::runtime_error(sql + ": " + PQerrorMessage(connection.get()));
  }
  std::vector<std::string> values;
  for (int i = 0; i < PQntuples(result.get()); ++i) values.emplace_back(PQgetvalue(result.get(), i, 0));
  return values;
}

// `url` with another database's name.
std::string WithDatabase(const std::string& url, const std::string& name) {
  const std::size_t authority = url.find("://") + 3;
  const std::size_t path = url.find('/', authority);
  const std::size_t query = url.find('?', authority);
  const std::string rest = query == std::string::npos ? "" : url.substr(query);
  return url.substr(0, std::min(path, query)) + "/" + name + rest;
}

// For destructors: a test may have stopped the server or filled its disk.
void TryExecute(const std::string& url, const std::string& sql) {
  try {
    Execute(url, sql);
  } catch (const std::exception&) {
  }
}

// The server of all of the program's databases, with the migrated database from which they are copied.
class Server {
 public:
  static Server& Instance() {
    static Server server;
    return server;
  }

  std::string NewName() { return "enfilade_test_" + std::to_string(getpid()) + "_" + std::to_string(++count_); }
  std::string UrlOf(const std::string& name) const { return WithDatabase(url_, name); }
  const std::string& url() const { return url_; }
  const std::string& migrated() const { return migrated_; }

 private:
  Server() {
    const char* given = std::getenv("ENFILADE_TEST_DATABASE");
    url_ = given ? given : Cluster::Instance().url();
    migrated_ = NewName();
    Execute(url_, "CREATE DATABASE " + migrated_);
    const CommandResult migrate = RunCommand({ProjectFile("deploy/database/migrate"), "up", UrlOf(migrated_)});
    if (migrate.exit_code != 0) throw std::runtime_error("the migrations failed:\n" + migrate.output);
  }
  ~Server() { TryExecute(url_, "DROP DATABASE " + migrated_ + " WITH (FORCE)"); }

  std::string url_;
  std::string migrated_;
  std::atomic<int> count_ = 0;
};

}  // namespace

TestDatabase::TestDatabase(Content content) {
  Server& server = Server::Instance();
  name_ = server.NewName();
  url_ = server.UrlOf(name_);
  const std::string origin = content == Content::kMigrated ? server.migrated() : "template1";
  Execute(server.url(), "CREATE DATABASE " + name_ + " TEMPLATE " + origin);
}

TestDatabase::~TestDatabase() { TryExecute(Server::Instance().url(), "DROP DATABASE " + name_ + " WITH (FORCE)"); }

std::vector<std::string> TestDatabase::Sql(const std::string& sql) const {
  try {
    return Execute(url_, sql);
  } catch (const std::exception& failure) {
    ADD_FAILURE() << failure.what();
    return {};
  }
}

std::string TestDatabase::SqlValue(const std::string& sql) const {
  const std::vector<std::string> values = Sql(sql);
  return values.empty() ? "" : values.front();
}

DatabaseTest::DatabaseTest() {
  auto pool = storage::postgres::Pool::Create({.url = database_.url()});
  if (!pool.ok()) throw std::runtime_error(pool.status().ToString());
  pool_ = *std::move(pool);
}

}  // namespace enfilade::testing
