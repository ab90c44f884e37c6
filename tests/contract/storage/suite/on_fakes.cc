// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/suite/backend.h"

namespace enfilade::testing {

std::unique_ptr<Backend> MakeBackend() { return MakeInMemoryBackend(); }

}  // namespace enfilade::testing
