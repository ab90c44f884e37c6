// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/audit_store.h"

#include "storage/postgres/driver/rows.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;

constexpr Statement kListAuditEntries{
    "reading the audit trail",
    "SELECT audit_id, time, actor, action, resource, before::text, after::text"
    " FROM enfilade.audit_log WHERE site_id = $1 AND ($3 = 0 OR audit_id < $3)"
    " AND ($2 = '' OR resource = $2 OR starts_with(resource, $2 || '/')) ORDER BY audit_id DESC LIMIT $4"};

AuditEntry ReadEntry(Row& row) {
  AuditEntry entry;
  entry.id = row.Int64();
  entry.time = row.Time();
  entry.actor = row.Text();
  entry.action = static_cast<AuditAction>(row.Int16());
  entry.resource = row.Text();
  entry.before = row.OptionalText().value_or("");
  entry.after = row.OptionalText().value_or("");
  return entry;
}

}  // namespace

absl::StatusOr<std::vector<AuditEntry>> AuditStore::List(const CallContext& context, const SiteId& site,
                                                         const std::string& resource, std::int64_t before,
                                                         int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kListAuditEntries,
                                                            Params(site, resource, before, std::int64_t{limit})));
  return storage::postgres::ReadRows(result, ReadEntry);
}

}  // namespace enfilade::storage
