// SPDX-License-Identifier: Apache-2.0
#include "client/import/import_report.h"

namespace enfilade::client {

const char* ToString(ImportLine::Outcome outcome) {
  switch (outcome) {
    case ImportLine::Outcome::kTaken:
      return "taken";
    case ImportLine::Outcome::kRefused:
      return "refused";
    case ImportLine::Outcome::kRemark:
      return "remark";
  }
  return "?";
}

void ImportReport::Taken(const std::string& item, const std::string& name, const std::string& remark) {
  lines_.push_back({item, ImportLine::Outcome::kTaken, name, remark});
  ++taken_;
}

void ImportReport::Refused(const std::string& item, const std::string& why) {
  lines_.push_back({item, ImportLine::Outcome::kRefused, "", why});
  ++refused_;
}

void ImportReport::Remark(const std::string& item, const std::string& remark) {
  lines_.push_back({item, ImportLine::Outcome::kRemark, "", remark});
}

bool EndsImport(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status) || absl::IsPermissionDenied(status);
}

}  // namespace enfilade::client
