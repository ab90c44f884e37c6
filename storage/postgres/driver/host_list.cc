// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/host_list.h"

#include <libpq-fe.h>

#include <algorithm>
#include <string_view>

#include "absl/strings/str_split.h"
#include "storage/postgres/driver/connection.h"

namespace enfilade::storage::postgres {
namespace {

using Parsed = std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)>;

std::string ValueOf(const Parsed& parsed, std::string_view keyword) {
  for (const PQconninfoOption* option = parsed.get(); option != nullptr && option->keyword != nullptr; ++option) {
    if (keyword == option->keyword && option->val != nullptr) return option->val;
  }
  return {};
}

std::vector<std::string> SplitList(const std::string& list) {
  if (list.empty()) return {};
  return absl::StrSplit(list, ',');
}

// The value for host `i`: a list of one is for all.
std::string At(const std::vector<std::string>& list, std::size_t i) {
  if (list.size() == 1) return list.front();
  return i < list.size() ? list[i] : std::string();
}

}  // namespace

std::vector<Host> HostsOf(const std::string& url) {
  const Parsed parsed(PQconninfoParse(url.c_str(), nullptr), &PQconninfoFree);
  const std::vector<std::string> hosts = SplitList(ValueOf(parsed, "host"));
  const std::vector<std::string> addresses = SplitList(ValueOf(parsed, "hostaddr"));
  const std::vector<std::string> ports = SplitList(ValueOf(parsed, "port"));
  const std::size_t count = std::max(hosts.size(), addresses.size());
  // A list that libpq refuses is left to it, for its message.
  const auto fits = [&](const auto& list) { return list.size() <= 1 || list.size() == count; };
  const bool whole = (hosts.empty() || hosts.size() == count) && (addresses.empty() || addresses.size() == count);
  if (count < 2 || !whole || !fits(ports) || ValueOf(parsed, "target_session_attrs") == "prefer-standby")
    return {Host{}};
  std::vector<Host> all;
  for (std::size_t i = 0; i < count; ++i) all.push_back({At(hosts, i), At(addresses, i), At(ports, i)});
  return all;
}

absl::StatusOr<std::unique_ptr<Connection>> HostList::Open(const std::string& application_name,
                                                           std::chrono::steady_clock::time_point deadline) {
  const std::size_t first = last_good_;
  absl::Status last;
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    const std::size_t index = (first + i) % hosts_.size();
    const auto now = std::chrono::steady_clock::now();
    const auto share = (deadline - now) / static_cast<int>(hosts_.size() - i);
    auto opened = Connection::Open(url_, hosts_[index], application_name, now + share);
    if (opened.ok()) {
      last_good_ = index;
      return opened;
    }
    last = opened.status();
  }
  return last;
}

}  // namespace enfilade::storage::postgres
