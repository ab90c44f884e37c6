// SPDX-License-Identifier: Apache-2.0
// What clang's libFuzzer calls.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/decoder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  enfilade::fuzz::Decode({reinterpret_cast<const char*>(data), size});
  return 0;
}
