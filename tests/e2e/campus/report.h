// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nlohmann/json.hpp"
#include "tests/e2e/campus/campus_run.h"
#include "tests/e2e/campus/log_run.h"

namespace enfilade::testing {

// Sums over campus runs.
struct CampusTotals {
  int runs = 0;
  int failed = 0;  // a program ended with an error, or never
  int exact = 0;
  Comparison sums;  // of the counts
  Consistency poses;
  GraphConsistency graph;
  std::vector<double> errors;      // m, final
  std::vector<double> yaw_errors;  // deg, final

  void Add(const CampusResult& result);
  double exact_share() const { return runs > 0 ? static_cast<double>(exact) / runs : 0.0; }
};

// The columns: docs/benchmarks.md.
std::string CampusHeader();
std::string CampusLine(const CampusRun& run, const CampusResult& result);
std::string Summary(const CampusTotals& totals);

nlohmann::json ToJson(const CampusRun& run, const CampusResult& result);
nlohmann::json ToJson(const CampusTotals& totals);

std::string LogHeader();
std::string LogLine(const LogRun& run, const LogResult& result);
nlohmann::json ToJson(const LogRun& run, const LogResult& result);

}  // namespace enfilade::testing
