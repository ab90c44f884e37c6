// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/feature_store.h"

#include "storage/postgres/driver/rows.h"

namespace enfilade::storage {
namespace {

using postgres::Bytes;
using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;

constexpr Statement kFind{"reading an image's features",
                          "SELECT features FROM enfilade.image_features WHERE site_id = $1 AND sha256 = $2"};
constexpr Statement kPutFeatures{"storing an image's features",
                                 "INSERT INTO enfilade.image_features (site_id, sha256, features)"
                                 " SELECT site_id, sha256, $3 FROM enfilade.blobs WHERE site_id = $1 AND sha256 = $2"
                                 " ON CONFLICT (site_id, sha256) DO UPDATE SET features = excluded.features"};

}  // namespace

absl::StatusOr<std::string> FeatureStore::Find(const CallContext& context, const SiteId& site,
                                               std::string_view sha256) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto found,
                            storage::postgres::ExecuteAlone(pool_, context, kFind, Params(site, Bytes{sha256})));
  if (found.rows() == 0) return std::string();
  return storage::postgres::ReadOne(
      found, [](Row& row) { return std::string(row.Bytes()); }, "the features");
}

absl::Status FeatureStore::Put(const CallContext& context, const SiteId& site, std::string_view sha256,
                               std::string_view features) const {
  return storage::postgres::ExecuteAlone(pool_, context, kPutFeatures, Params(site, Bytes{sha256}, Bytes{features}))
      .status();
}

}  // namespace enfilade::storage
