// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/sensor/record.h"
#include "storage/call_context.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/record_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// For one call of a store.
storage::CallContext SurveyContext();

// What is stored of a site's sessions. The stores and `proceed` must outlive it.
class SessionReader {
 public:
  // `proceed` is asked between portions of records; its error ends the reading.
  SessionReader(const storage::RecordStore& records, const storage::MappingStore& mappings, const SiteId& site,
                const std::function<absl::Status()>& proceed)
      : records_(records), mappings_(mappings), site_(site), proceed_(proceed) {}

  // In the order of the log, those of after `until` left out. An error of `take` ends it.
  absl::Status ReadRecords(const storage::Session& session, std::optional<TimeNs> until,
                           const std::function<absl::Status(sensor::Record)>& take) const;

  // What mapping has made of it, with its submaps' contents. Unset: nothing.
  absl::StatusOr<std::optional<storage::StoredMapping>> LoadMapping(const SessionId& session) const;

 private:
  const storage::RecordStore& records_;
  const storage::MappingStore& mappings_;
  const SiteId& site_;
  const std::function<absl::Status()>& proceed_;
};

}  // namespace enfilade::server
