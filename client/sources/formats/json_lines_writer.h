// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>

#include "client/sources/log_reader.h"

namespace enfilade::sources {

constexpr int kJsonLinesVersion = 1;

// The first line of a JSON-lines log (docs/logs.md), with its end.
std::string JsonLinesHeader();

// One line, with its end. Numbers have enough digits to read back the same bits. The path `entry.content` of an image
// or a point cloud is written unchanged: make it relative to the log's folder first. INVALID_ARGUMENT: a door report or
// a withheld record, which have no place in a log; a number other than a range that is not finite.
absl::StatusOr<std::string> ToJsonLine(const LogEntry& entry);

}  // namespace enfilade::sources
