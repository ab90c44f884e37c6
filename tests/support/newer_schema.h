// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tests/support/command.h"
#include "tests/support/database.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {

// The project's migrations and, after them, changes that this program does not know.
class NewerSchema {
 public:
  NewerSchema();

  // Adds a change. Its deploy script executes `sql`; its revert script executes `undo`. `oldest_program` is empty for a
  // change that says nothing about programs.
  void Add(const std::string& change, const std::string& sql, const std::string& undo,
           const std::string& oldest_program);
  // deploy/database/migrate with these migrations: `command` is "up" or "down".
  CommandResult Migrate(const std::string& command, const TestDatabase& database, const std::string& change = "") const;

 private:
  void Write(const std::string& script, const std::string& sql) const;

  TemporaryDirectory directory_;
};

}  // namespace enfilade::testing
