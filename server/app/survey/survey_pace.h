// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "storage/graph/survey_store.h"

namespace enfilade::server {

// A survey costs about as much as all that it sees. While robots record at a site, it is therefore surveyed each time
// that it has grown by a share, so that all surveys together cost a bounded multiple of the last one.
struct SurveyPace {
  double growth = 1.0;        // of what the last survey saw
  double patience_s = 300.0;  // what is new waits no longer than this

  friend bool operator==(const SurveyPace&, const SurveyPace&) = default;
};

// What the last survey of a site left. None yet: all zero.
struct LastSurvey {
  std::int64_t scans = 0;    // that it saw
  std::int64_t pending = 0;  // of these, those that are still to be surveyed: maps have changed
  double age_s = 0.0;
};

// Whether to survey a site now. Once nothing is under way there, always.
inline bool IsSurveyDue(const storage::PendingSurvey& pending, const LastSurvey& last, const SurveyPace& pace) {
  if (!pending.under_way || last.scans == 0) return true;
  if (pending.waiting_s >= pace.patience_s && last.age_s >= pace.patience_s) return true;
  return static_cast<double>(pending.scans - last.pending) >= pace.growth * static_cast<double>(last.scans);
}

}  // namespace enfilade::server
