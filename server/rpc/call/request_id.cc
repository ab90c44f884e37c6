// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/request_id.h"

#include <algorithm>
#include <cstdint>
#include <random>

namespace enfilade::server {
namespace {

constexpr std::size_t kMaxRequestIdBytes = 128;
constexpr int kDigits = 16;

// std::isalnum depends on the locale.
bool MayBeInRequestId(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view("-_.:/+=").find(c) != std::string_view::npos;
}

}  // namespace

bool IsValidRequestId(std::string_view id) {
  return !id.empty() && id.size() <= kMaxRequestIdBytes && std::all_of(id.begin(), id.end(), MayBeInRequestId);
}

std::string NewRequestId() {
  thread_local std::mt19937_64 random{(std::uint64_t{std::random_device{}()} << 32U) ^ std::random_device{}()};
  std::uint64_t bits = random();
  std::string id(kDigits, '0');
  for (char& digit : id) {
    digit = "0123456789abcdef"[bits & 0xFU];
    bits >>= 4U;
  }
  return id;
}

std::string RequestIdOrNew(std::string_view given) {
  return IsValidRequestId(given) ? std::string(given) : NewRequestId();
}

}  // namespace enfilade::server
