// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/edit/map_edit.h"
#include "enfilade/v1/map_edit.pb.h"

namespace enfilade::cli {

// The edits of a YAML file (docs/editing.md describes it) on the lattice of a draft, in the file's order. They have no
// ids yet. INVALID_ARGUMENT naming the line, the edit (edits[0] is the first) and what is wrong: also what
// edit::Validate refuses.
absl::StatusOr<std::vector<v1::MapEdit>> ReadEdits(std::string_view yaml, const edit::Lattice& lattice);

// Gives each edit an id (a UUID) that depends on the draft, the edit and how many of the edits before it are the same:
// who sends a file again, or with more edits at its end, sends those that are there already with the same ids.
void GiveIds(const std::string& draft, std::vector<v1::MapEdit>& edits);

}  // namespace enfilade::cli
