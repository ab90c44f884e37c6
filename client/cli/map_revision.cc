// SPDX-License-Identifier: Apache-2.0
#include "client/cli/map_revision.h"

#include <algorithm>
#include <iostream>

#include "client/cli/remote.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {

absl::StatusOr<std::string> RevisionNameOf(const v1::Map& map, const std::string& revision) {
  if (revision.empty()) {
    if (!map.latest_revision().empty()) return map.latest_revision();
    return FailedPrecondition("\"{}\" has no revision yet: map a session into it, or import one", map.display_name());
  }
  const bool is_number = std::all_of(revision.begin(), revision.end(), [](char c) { return c >= '0' && c <= '9'; });
  return map.name() + (is_number ? "/revisions/" : "/aliases/") + revision;
}

absl::StatusOr<std::string> FindRevision(const client::Connection& connection, const Globals& globals,
                                         const std::string& text) {
  const bool is_resource = text.starts_with("sites/");
  if (is_resource && (text.find("/revisions/") != std::string::npos || text.find("/aliases/") != std::string::npos)) {
    return text;
  }
  const std::size_t at = text.rfind('@');
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, text.substr(0, at)));
  if (at == std::string::npos) return RevisionNameOf(map, "");
  if (at + 1 == text.size())
    return InvalidArgument("\"{}\": expected the number of a revision or an alias after @", text);
  return RevisionNameOf(map, text.substr(at + 1));
}

nlohmann::json RevisionToJson(const v1::MapRevision& revision) {
  return {{"revision", revision.name()},
          {"width", revision.width()},
          {"height", revision.height()},
          {"resolution_m", revision.resolution_m()}};
}

void PrintRevision(const v1::MapRevision& revision) {
  std::cout << revision.name() << ": " << revision.width() << " x " << revision.height() << " cells of "
            << revision.resolution_m() << " m\n";
}

}  // namespace enfilade::cli
