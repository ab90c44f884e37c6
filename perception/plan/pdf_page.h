// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade::perception {

// One page of a PDF as a PNG with 4000 pixels on its longer side, rendered by pdftocairo (poppler-utils) in a process
// of its own, within 30 s. `page` from 1; 0: the only one. FAILED_PRECONDITION: poppler-utils is not installed.
// INVALID_ARGUMENT: damaged or encrypted; several pages and none chosen; no such page.
absl::StatusOr<std::string> RenderPdfPage(std::string_view pdf, int page);

}  // namespace enfilade::perception
