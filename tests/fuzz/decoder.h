// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

// What a fuzzer needs of one decoder of outside bytes. Each *_decoder.cc defines both functions for one program.
namespace enfilade::fuzz {

// Small valid inputs, written by the project's own code.
std::vector<std::string> Seeds();

// Decodes the bytes, whatever they are; false if they are refused. Aborts if the result breaks the decoder's promises.
// It must neither crash, throw nor need memory out of proportion. No seed is refused.
bool Decode(std::string_view bytes);

// Aborts the program, naming what does not hold.
inline void Expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

}  // namespace enfilade::fuzz
