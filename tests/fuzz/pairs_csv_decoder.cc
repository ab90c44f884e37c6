// SPDX-License-Identifier: Apache-2.0
// Points that people have shown on a plan and in a map.
#include "client/cli/commands/prior/prior_fit_files.h"
#include "tests/fuzz/memory_file.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  return {"# clicked\n10,20,1.5,2.5\n30, 40, 3, 4\n", "1e3,-2.5,0,0.125\r\n\r\n\t5,6,7,8",
          "0,0,0,0\n900,0,45,0\n0,400,0,-20\n"};
}

bool Decode(std::string_view bytes) {
  const MemoryFile file(bytes);
  const auto points = cli::ReadSheetPoints(file.path());
  const auto pairs = cli::ReadPairs(file.path());
  for (const absl::Status& status : {points.status(), pairs.status()}) {
    Expect(status.ok() || status.code() == absl::StatusCode::kInvalidArgument, "what is no list is refused as such");
  }
  if (points.ok() && pairs.ok()) Expect(points->empty() && pairs->empty(), "a line has one number of columns");
  if (!pairs.ok()) return false;
  for (const prior::ControlPair& pair : *pairs) {
    Expect(pair.point_sheet.allFinite() && pair.point_map.allFinite(), "a point is finite");
  }
  const auto fit = prior::FitPairs(*pairs, 1000);
  Expect(fit.ok() || fit.status().code() == absl::StatusCode::kInvalidArgument, "pairs fit, or are refused");
  if (fit.ok()) {
    Expect(fit->T_map_sheet.linear.allFinite() && fit->T_map_sheet.offset.allFinite(), "a place is finite");
    Expect(fit->residuals.size() == pairs->size(), "each pair has a residual");
  }
  return true;
}

}  // namespace enfilade::fuzz
