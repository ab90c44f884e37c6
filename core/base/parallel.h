// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace enfilade {

// Calls `work` once with each index below `count`, on up to `threads` threads, of which the caller's is one, and
// returns when all calls have. Threads take the indices in turn, so calls may take unequally long. Calls write only
// what is their own, such as one element of a vector, and read nothing that others write: so the result does not depend
// on the number of threads or on which is faster. What a call throws is thrown here, after all others have ended. Where
// the system has no more threads, fewer do the work.
void ForEachIndex(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace enfilade
