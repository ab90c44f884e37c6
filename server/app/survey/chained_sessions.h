// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/time.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/session_chain.h"
#include "core/slam/slam_options.h"
#include "server/app/survey/session_reader.h"
#include "storage/sessions/mapping_store.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// Appends a drive's sessions to a chain, from their rows and logs. The reader, the options and the sessions must
// outlive it. Errors are those of the reader.
class ChainedSessions {
 public:
  // `sessions`: those that are mapped, in order. What they recorded after `until` is left out.
  ChainedSessions(const SessionReader& reader, const sensor::ScanPairingOptions& pairing, const slam::SlamOptions& slam,
                  std::span<const storage::Session* const> sessions, std::optional<TimeNs> until)
      : reader_(reader), pairing_(pairing), slam_(slam), sessions_(sessions), until_(until) {}

  // How many sessions are in the chain.
  std::size_t appended() const { return appended_; }
  bool done() const { return appended_ == sessions_.size(); }

  // Appends the next session. The pieces of one that was cut are appended at once, as they were mapped. One whose rows
  // do not fit the chain, or that is to be used in part only, is mapped again by its keyframes. After an error the
  // chain is as before.
  absl::Status AppendNext(slam::SessionChain& chain);

 private:
  // Of one session, in order.
  using Pieces = std::vector<const storage::Session*>;
  // A session as it was mapped.
  struct Whole {
    Pieces pieces;
    storage::StoredMapping mapping;
  };
  // Record sequences of scans; unset: all.
  using Wanted = std::optional<std::set<std::int64_t>>;

  absl::StatusOr<storage::StoredMapping> Load(const storage::Session& session) const;
  absl::StatusOr<Whole> ReadNext();
  bool IsAfter(TimeNs time) const { return until_ && time > *until_; }
  bool IsInPart(const slam::SlamMap& map) const;
  std::set<std::int64_t> ScansOf(const slam::SlamMap& map) const;
  absl::StatusOr<std::vector<sensor::PairedScan>> ReadScans(const Pieces& pieces, const Wanted& wanted) const;
  absl::StatusOr<slam::ChainedSession> MapAgain(const Pieces& pieces, const std::set<std::int64_t>& keyframes) const;

  const SessionReader& reader_;
  const sensor::ScanPairingOptions& pairing_;
  const slam::SlamOptions& slam_;
  const std::span<const storage::Session* const> sessions_;
  const std::optional<TimeNs> until_;
  std::size_t appended_ = 0;
  std::optional<storage::StoredMapping> next_;  // of the first session that is not appended, if it was read
};

}  // namespace enfilade::server
