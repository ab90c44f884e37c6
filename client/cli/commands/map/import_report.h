// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <iostream>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/output.h"

namespace enfilade::cli {

// What became of each row of the source.
class Report {
 public:
  void Taken(const std::string& row, const std::string& name, const std::string& remark = "") {
    lines_.push_back({row, "taken", name, remark});
    ++taken_;
  }
  void Refused(const std::string& row, const std::string& why) {
    lines_.push_back({row, "refused", "", why});
    ++refused_;
  }
  void Remark(const std::string& row, const std::string& remark) { lines_.push_back({row, "remark", "", remark}); }

  void Print(const Globals& globals) const {
    if (globals.json) {
      nlohmann::json rows = nlohmann::json::array();
      for (const auto& line : lines_) {
        rows.push_back({{"row", line[0]}, {"outcome", line[1]}, {"name", line[2]}, {"remark", line[3]}});
      }
      return PrintJson(std::cout, {{"taken", taken_}, {"refused", refused_}, {"rows", std::move(rows)}});
    }
    PrintTable(std::cout, {"ROW", "OUTCOME", "NAME", "REMARK"}, lines_);
    std::cout << taken_ << " taken, " << refused_ << " refused\n";
  }

 private:
  std::vector<std::vector<std::string>> lines_;
  int taken_ = 0;
  int refused_ = 0;
};

// Whether the rest of the import would meet the same.
inline bool EndsImport(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status) || absl::IsPermissionDenied(status);
}

}  // namespace enfilade::cli
