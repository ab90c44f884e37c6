// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/watch/resume_token.h"

#include <array>
#include <charconv>
#include <cstdint>

#include "fmt/format.h"

namespace enfilade::server {
namespace {

constexpr std::uint64_t kForm = 1;  // of the token

// Exactly as many hexadecimal numbers as `numbers` takes, with dashes between them.
template <std::size_t N>
bool ReadNumbers(const std::string& text, std::array<std::uint64_t, N>& numbers) {
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < N; ++i) {
    if (i > 0 && (at == end || *at++ != '-')) return false;
    const auto [next, error] = std::from_chars(at, end, numbers[i], 16);
    if (error != std::errc()) return false;
    at = next;
  }
  return at == end;
}

}  // namespace

std::string ToResumeToken(const WatchPosition& position) {
  return fmt::format(
      "{:x}-{:x}-{:x}-{:x}-{:x}-{:x}-{:x}-{:x}", kForm, static_cast<std::uint64_t>(position.site_created),
      static_cast<std::uint64_t>(position.graph_version), static_cast<std::uint64_t>(position.report_version),
      static_cast<std::uint64_t>(position.time), static_cast<std::uint64_t>(position.finished_since),
      position.sessions_digest, position.revisions_digest);
}

std::optional<WatchPosition> ParseWatchToken(const std::string& token) {
  std::array<std::uint64_t, 8> numbers{};
  if (!ReadNumbers(token, numbers) || numbers[0] != kForm) return std::nullopt;
  for (std::size_t i = 1; i <= 5; ++i) {
    if (numbers[i] > static_cast<std::uint64_t>(INT64_MAX)) return std::nullopt;
  }
  WatchPosition position;
  position.site_created = static_cast<TimeNs>(numbers[1]);
  position.graph_version = static_cast<std::int64_t>(numbers[2]);
  position.report_version = static_cast<std::int64_t>(numbers[3]);
  position.time = static_cast<TimeNs>(numbers[4]);
  position.finished_since = static_cast<TimeNs>(numbers[5]);
  position.sessions_digest = numbers[6];
  position.revisions_digest = numbers[7];
  return position;
}

}  // namespace enfilade::server
