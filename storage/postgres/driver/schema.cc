// SPDX-License-Identifier: Apache-2.0
#include "storage/schema.h"

#include <algorithm>

#include "storage/postgres/driver/migrations.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::kMigrations;
using postgres::Params;
using postgres::Row;
using postgres::Statement;

constexpr Statement kHasRegistry{"looking for migrations", "SELECT to_regclass('sqitch.changes') IS NOT NULL"};
constexpr Statement kSelectDeployed{
    "looking for migrations",
    "SELECT change FROM sqitch.changes WHERE project = 'enfilade' ORDER BY committed_at, planned_at"};

}  // namespace

absl::StatusOr<SchemaState> CheckSchema(const CallContext& context, postgres::Pool& pool) {
  SchemaState state;
  state.expected = kMigrations.back();
  ENFILADE_ASSIGN_OR_RETURN(const auto registry,
                            storage::postgres::ExecuteAlone(pool, context, kHasRegistry, Params()));
  ENFILADE_ASSIGN_OR_RETURN(const bool migrated, storage::postgres::ReadOne(
                                                     registry, [](Row& row) { return row.Bool(); }, "the registry"));
  if (!migrated) return state;
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool, context, kSelectDeployed, Params()));
  ENFILADE_ASSIGN_OR_RETURN(const auto deployed,
                            storage::postgres::ReadRows(result, [](Row& row) { return std::string(row.Text()); }));
  if (deployed.empty()) return state;
  state.deployed = deployed.back();
  const auto unknown = [](const std::string& change) {
    return std::find(kMigrations.begin(), kMigrations.end(), change) == kMigrations.end();
  };
  if (std::any_of(deployed.begin(), deployed.end(), unknown)) {
    state.position = SchemaState::Position::kAhead;
  } else if (deployed.size() < kMigrations.size()) {
    state.position = SchemaState::Position::kBehind;
  } else {
    state.position = SchemaState::Position::kAtHead;
  }
  return state;
}

}  // namespace enfilade::storage
