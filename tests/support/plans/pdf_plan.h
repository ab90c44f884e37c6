// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "fmt/format.h"

namespace enfilade::testing {

// A PDF, each page of which shows 4 x 4 rooms, and of which poppler rebuilds the table of contents. `trailer`: more
// entries of its trailer.
inline std::string PdfPlan(int pages, const std::string& trailer = "") {
  std::string lines = "12 w ";
  for (int i = 0; i <= 4; ++i) lines += fmt::format("{0} 100 m {0} 500 l S 100 {0} m 500 {0} l S ", 100 + 100 * i);
  std::string kids;
  for (int i = 0; i < pages; ++i) kids += fmt::format("{} 0 R ", 10 + i);
  std::string pdf = fmt::format(
      "%PDF-1.4\n1 0 obj\n<< /Type /Catalog /Pages 2 0 R >>\nendobj\n"
      "2 0 obj\n<< /Type /Pages /Kids [{}] /Count {} >>\nendobj\n"
      "3 0 obj\n<< /Length {} >>\nstream\n{}\nendstream\nendobj\n",
      kids, pages, lines.size(), lines);
  for (int i = 0; i < pages; ++i) {
    pdf += fmt::format("{} 0 obj\n<< /Type /Page /Parent 2 0 R /MediaBox [0 0 600 600] /Contents 3 0 R >>\nendobj\n",
                       10 + i);
  }
  return pdf + "trailer\n<< /Root 1 0 R " + trailer + " >>\n%%EOF\n";
}

inline std::string EncryptedPdfPlan() {
  const std::string key(32, 'k');
  return PdfPlan(1,
                 fmt::format("/ID [(a) (b)] /Encrypt << /Filter /Standard /V 1 /R 2 /P -4 /O ({0}) /U ({0}) >>", key));
}

}  // namespace enfilade::testing
