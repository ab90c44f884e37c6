// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"
#include "core/base/error.h"

namespace enfilade::storage {

// ABORTED: `name` was changed since the caller read it.
inline absl::Status StaleEtag(const std::string& name) {
  return Aborted("{} has been changed meanwhile: read it again and repeat the change", name);
}

}  // namespace enfilade::storage
