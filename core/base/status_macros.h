// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

// Early return on an error of absl::Status / absl::StatusOr (this abseil release ships no such macros).

#define ENFILADE_RETURN_IF_ERROR(expression)                                  \
  do {                                                                        \
    if (absl::Status enfilade_status = (expression); !enfilade_status.ok()) { \
      return enfilade_status;                                                 \
    }                                                                         \
  } while (false)

#define ENFILADE_CONCAT_INNER(a, b) a##b
#define ENFILADE_CONCAT(a, b) ENFILADE_CONCAT_INNER(a, b)

#define ENFILADE_ASSIGN_OR_RETURN(declaration, expression) \
  ENFILADE_ASSIGN_OR_RETURN_INNER(ENFILADE_CONCAT(enfilade_status_or_, __LINE__), declaration, expression)

#define ENFILADE_ASSIGN_OR_RETURN_INNER(temporary, declaration, expression) \
  auto temporary = (expression);                                            \
  if (!temporary.ok()) {                                                    \
    return std::move(temporary).status();                                   \
  }                                                                         \
  declaration = *std::move(temporary)
