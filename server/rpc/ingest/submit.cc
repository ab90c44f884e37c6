// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/ingest/submit.h"

#include <vector>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::server {

absl::StatusOr<std::int64_t> SubmitRecord(const Services& services, const Call& call, const std::string& session,
                                          const v1::Record& message, const std::string* blob) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName name, convert::ParseSessionName("session", session));
  ENFILADE_ASSIGN_OR_RETURN(const sensor::Record record, enfilade::convert::FromProto(message));
  std::vector<storage::BlobView> blobs;
  if (blob) {
    const sensor::BlobRef& content = *sensor::FindBlob(record);
    if (content.size != static_cast<std::int64_t>(blob->size()) || content.sha256 != Sha256(*blob)) {
      return InvalidArgument("size_bytes and sha256 of content do not match the {} bytes of data", blob->size());
    }
    blobs.push_back({content.sha256, *blob});
  }
  const storage::RecordBatch batch{name.site, name.session, absl::MakeConstSpan(&record, 1), blobs};
  ENFILADE_ASSIGN_OR_RETURN(const storage::AppendResult result, services.records.Append(call.context(), batch));
  services.metrics.CountRecordsStored(result.inserted, result.duplicates);
  services.mapping.Wake(name.site, name.session);
  return result.acknowledged_sequence;
}

void CompleteContent(const std::string& data, v1::BlobRef& content) {
  if (content.sha256().empty()) content.set_sha256(Sha256(data));
  if (content.size_bytes() == 0) content.set_size_bytes(static_cast<std::int64_t>(data.size()));
}

}  // namespace enfilade::server
