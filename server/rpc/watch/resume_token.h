// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "server/app/watch/site_updates.h"

namespace enfilade::server {

// How far a watch of a site has come, for its client: numbers with dashes between them.
std::string ToResumeToken(const WatchPosition& position);
// Unset if it is none of ours, or of another version of the server: then the watch begins anew.
std::optional<WatchPosition> ParseWatchToken(const std::string& token);

}  // namespace enfilade::server
