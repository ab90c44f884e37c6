// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/pdf_page.h"

#include <cstdlib>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "io/program.h"

namespace enfilade::perception {
namespace {

absl::StatusOr<io::ProgramResult> RunPoppler(const std::vector<std::string>& command, std::string_view pdf) {
  absl::StatusOr<io::ProgramResult> result = io::RunProgram(command, pdf);
  if (absl::IsNotFound(result.status())) {
    return FailedPrecondition("PDF is read by {}, which is not installed: apt-get install poppler-utils", command[0]);
  }
  if (!result.ok()) return result;
  if (result->exit_code == 0) return result;
  if (result->errors.find("password") != std::string::npos) return InvalidArgument("the PDF is encrypted");
  return InvalidArgument("the PDF cannot be read: {}", result->errors.substr(0, result->errors.find('\n')));
}

absl::StatusOr<int> CountPages(std::string_view pdf) {
  ENFILADE_ASSIGN_OR_RETURN(const io::ProgramResult info, RunPoppler({"pdfinfo", "-"}, pdf));
  const std::size_t at = info.output.find("Pages:");
  const int pages = at == std::string::npos ? 0 : std::atoi(info.output.c_str() + at + 6);
  if (pages < 1) return InvalidArgument("the PDF has no pages");
  return pages;
}

}  // namespace

absl::StatusOr<std::string> RenderPdfPage(std::string_view pdf, int page) {
  ENFILADE_ASSIGN_OR_RETURN(const int pages, CountPages(pdf));
  if (page == 0 && pages > 1) return InvalidArgument("the PDF has {} pages: choose one (page)", pages);
  if (page < 0 || page > pages) return InvalidArgument("page {}: the PDF has {}", page, pages);
  const std::string number = std::to_string(page == 0 ? 1 : page);
  ENFILADE_ASSIGN_OR_RETURN(io::ProgramResult rendered, RunPoppler({"pdftocairo", "-png", "-singlefile", "-f", number,
                                                                    "-l", number, "-scale-to", "4000", "-", "-"},
                                                                   pdf));
  return std::move(rendered.output);
}

}  // namespace enfilade::perception
