// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>

#include "client/sources/log_reader.h"

namespace enfilade::sources {

constexpr int kJsonLinesVersion = 1;

// The first line of a JSON-lines log (docs/logs.md), with its end.
std::string JsonLinesHeader();

// One line, with its end. Numbers have as many digits as it takes to read back the same bits. Of an image or a point
// cloud `entry.content` is written as it is: make it relative to the log's folder first. INVALID_ARGUMENT for
// Withheld, which no log holds, and for numbers that JSON cannot hold (ranges apart).
absl::StatusOr<std::string> ToJsonLine(const LogEntry& entry);

}  // namespace enfilade::sources
