// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <string>
#include <vector>

namespace enfilade::fuzz {

// One of the seeds with up to eight random changes: bits and bytes, extreme binary and decimal numbers, and stretches
// that are cut out, repeated or taken from another seed. At most kMaxInputBytes. `seeds` must not be empty.
std::string Mutate(const std::vector<std::string>& seeds, std::mt19937_64& random);

constexpr std::size_t kMaxInputBytes = 1U << 16;

}  // namespace enfilade::fuzz
