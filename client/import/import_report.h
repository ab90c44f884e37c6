// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"

namespace enfilade::client {

// What became of one item of a source.
struct ImportLine {
  enum class Outcome { kTaken, kRefused, kRemark };
  std::string item;  // as the source names it: "levels L1", "LINKPOINTS 7"
  Outcome outcome = Outcome::kTaken;
  std::string name;    // the new resource; empty unless taken
  std::string remark;  // why it was refused, or what is different from the source
};

const char* ToString(ImportLine::Outcome outcome);  // "taken", "refused", "remark"

// The lines of one import, in its order.
class ImportReport {
 public:
  void Taken(const std::string& item, const std::string& name, const std::string& remark = "");
  void Refused(const std::string& item, const std::string& why);
  void Remark(const std::string& item, const std::string& remark);

  const std::vector<ImportLine>& lines() const { return lines_; }
  int taken() const { return taken_; }
  int refused() const { return refused_; }

 private:
  std::vector<ImportLine> lines_;
  int taken_ = 0;
  int refused_ = 0;
};

// Whether every further call of an import would fail alike: the server is away, or the caller may not change the site.
bool EndsImport(const absl::Status& status);

}  // namespace enfilade::client
