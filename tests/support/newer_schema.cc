// SPDX-License-Identifier: Apache-2.0
#include "tests/support/newer_schema.h"

#include <filesystem>
#include <fstream>

namespace enfilade::testing {

NewerSchema::NewerSchema() {
  const auto copy = [&](const std::string& what) {
    std::filesystem::create_directories((directory_.path() / what).parent_path());
    std::filesystem::copy(ProjectFile(what), directory_.path() / what, std::filesystem::copy_options::recursive);
  };
  copy("deploy/database/migrate");
  copy("migrations");
}

void NewerSchema::Add(const std::string& change, const std::string& sql, const std::string& undo,
                      const std::string& oldest_program) {
  const std::string permit = "INSERT INTO enfilade.schema_compatibility VALUES ('" + change + "', '";
  Write("deploy/" + change + ".sql", sql + (oldest_program.empty() ? "" : permit + oldest_program + "');"));
  Write("revert/" + change + ".sql",
        undo + "DELETE FROM enfilade.schema_compatibility WHERE change = '" + change + "';");
  Write("verify/" + change + ".sql", "SELECT 1;");
  std::ofstream plan(directory_.path() / "migrations/sqitch.plan", std::ios::app);
  plan << change << " 2030-01-01T00:00:00Z Enfilade <enfilade@localhost> # Later\n";
}

void NewerSchema::Write(const std::string& script, const std::string& sql) const {
  std::ofstream(directory_.path() / "migrations" / script) << "BEGIN;\n" << sql << "\nCOMMIT;\n";
}

CommandResult NewerSchema::Migrate(const std::string& command, const TestDatabase& database,
                                   const std::string& change) const {
  std::vector<std::string> arguments = {directory_.path() / "deploy/database/migrate", command, database.url()};
  if (!change.empty()) arguments.push_back(change);
  return RunCommand(arguments);
}

}  // namespace enfilade::testing
