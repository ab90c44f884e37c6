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
using postgres::ReadOne;
using postgres::ReadRows;
using postgres::Row;
using postgres::Statement;

constexpr Statement kFindTables{"looking for migrations",
                                "SELECT to_regclass('sqitch.changes') IS NOT NULL,"
                                " to_regclass('enfilade.schema_compatibility') IS NOT NULL"};
constexpr Statement kSelectDeployed{
    "looking for migrations",
    "SELECT change, NULL::text FROM sqitch.changes WHERE project = 'enfilade' ORDER BY committed_at, planned_at"};
constexpr Statement kSelectDeployedWithPrograms{
    "looking for migrations",
    "SELECT d.change, c.oldest_program FROM sqitch.changes d LEFT JOIN enfilade.schema_compatibility c USING (change)"
    " WHERE d.project = 'enfilade' ORDER BY d.committed_at, d.planned_at"};

struct DeployedChange {
  std::string name;
  std::string oldest_program;  // a change that says nothing breaks every program that does not know it
};

absl::StatusOr<std::vector<DeployedChange>> ReadDeployed(const CallContext& context, postgres::Pool& pool) {
  struct Tables {
    bool registry, compatibility;
  };
  ENFILADE_ASSIGN_OR_RETURN(const auto found, ExecuteAlone(pool, context, kFindTables, Params()));
  ENFILADE_ASSIGN_OR_RETURN(const Tables tables, ReadOne(
                                                     found,
                                                     [](Row& row) {
                                                       return Tables{row.Bool(), row.Bool()};
                                                     },
                                                     "the registry"));
  if (!tables.registry) return std::vector<DeployedChange>();
  const Statement& select = tables.compatibility ? kSelectDeployedWithPrograms : kSelectDeployed;
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool, context, select, Params()));
  return ReadRows(result, [](Row& row) {
    DeployedChange change;
    change.name = row.Text();
    change.oldest_program = row.OptionalText().value_or(change.name);
    return change;
  });
}

bool Knows(absl::Span<const std::string_view> known, const std::string& change) {
  return std::find(known.begin(), known.end(), change) != known.end();
}

}  // namespace

absl::Span<const std::string_view> KnownChanges() { return kMigrations; }

absl::StatusOr<SchemaState> CheckSchema(const CallContext& context, postgres::Pool& pool,
                                        absl::Span<const std::string_view> known) {
  SchemaState state;
  state.expected = known.back();
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<DeployedChange> deployed, ReadDeployed(context, pool));
  if (deployed.empty()) return state;
  state.deployed = deployed.back().name;
  std::size_t unknown = 0;
  for (const DeployedChange& change : deployed) {
    if (Knows(known, change.name)) continue;
    ++unknown;
    if (Knows(known, change.oldest_program)) continue;
    state.position = SchemaState::Position::kTooNew;
    state.breaking = change.name;
    state.required = change.oldest_program;
    return state;
  }
  if (deployed.size() - unknown < known.size()) {
    state.position = SchemaState::Position::kBehind;
  } else {
    state.position = unknown > 0 ? SchemaState::Position::kAhead : SchemaState::Position::kAtHead;
  }
  return state;
}

}  // namespace enfilade::storage
