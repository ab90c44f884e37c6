// SPDX-License-Identifier: Apache-2.0
#include "server/config/server_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <string_view>
#include <thread>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/options/yaml_options.h"
#include "fmt/format.h"

namespace enfilade::server {
namespace {

constexpr char kEnvironmentPrefix[] = "ENFILADE_SERVER_";

// Calls visit(key, reference) for every option. This is the only list of the options.
template <typename Options, typename Visitor>
void VisitOptions(Options& options, Visitor&& visit) {
  visit("listen.address", options.listen.address);
  visit("listen.tls_certificate", options.listen.tls_certificate);
  visit("listen.tls_key", options.listen.tls_key);
  visit("listen.tls_client_authorities", options.listen.tls_client_authorities);
  visit("listen.tls_revoked_directory", options.listen.tls_revoked_directory);
  visit("listen.insecure", options.listen.insecure);
  visit("listen.grace_s", options.listen.grace_s);
  visit("listen.max_message_bytes", options.listen.max_message_bytes);
  visit("listen.workers", options.listen.workers);
  visit("database.url", options.database.url);
  visit("database.max_connections", options.database.max_connections);
  visit("database.default_deadline_s", options.database.default_deadline_s);
  visit("graph.version_wait_s", options.graph.version_wait_s);
  visit("watches.max_per_site", options.watches.max_per_site);
  visit("watches.max_in_all", options.watches.max_in_all);
  visit("ingest.writers", options.ingest.writers);
  visit("ingest.stream_buffer_bytes", options.ingest.stream_buffer_bytes);
  visit("ingest.total_buffer_bytes", options.ingest.total_buffer_bytes);
  visit("ingest.transaction_bytes", options.ingest.transaction_bytes);
  visit("mapping.workers", options.mapping.workers);
  visit("mapping.lease_s", options.mapping.lease_s);
  visit("mapping.checkpoint_interval_s", options.mapping.checkpoint_interval_s);
  visit("mapping.revision_interval_s", options.mapping.revision_interval_s);
  visit("mapping.parked_bytes", options.mapping.parked_bytes);
  visit("mapping.pairing_window_s", options.mapping.pairing_window_s);
  visit("mapping.slam_options_file", options.mapping.slam_options_file);
  visit("mapping.slam_profiles_directory", options.mapping.slam_profiles_directory);
  closure::VisitDoorClosureOptions(
      options.closure, [&](const char* name, auto& value) { visit(fmt::format("closure.{}", name).c_str(), value); });
  visit("transfers.cache_directory", options.transfers.cache_directory);
  visit("transfers.cache_bytes", options.transfers.cache_bytes);
  visit("transfers.max_import_bytes", options.transfers.max_import_bytes);
  visit("transfers.upload_memory_bytes", options.transfers.upload_memory_bytes);
  visit("transfers.upload_disk_bytes", options.transfers.upload_disk_bytes);
  visit("transfers.upload_directory", options.transfers.upload_directory);
  visit("survey.share", options.survey.share);
  visit("survey.growth", options.survey.growth);
  visit("survey.interval_s", options.survey.interval_s);
  visit("survey.cache_bytes", options.survey.cache_bytes);
  visit("prior_maps.realign_s", options.prior_maps.realign_s);
  visit("retention.interval_s", options.retention.interval_s);
  visit("retention.undo_s", options.retention.undo_s);
  visit("retention.idle_session_s", options.retention.idle_session_s);
  visit("retention.deleted_session_s", options.retention.deleted_session_s);
  visit("retention.unused_blob_s", options.retention.unused_blob_s);
  visit("metrics.address", options.metrics.address);
  visit("log.level", options.log.level);
  visit("log.format", options.log.format);
}

absl::Status Parse(const Setting& setting, std::string& value) {
  value = setting.value;
  return absl::OkStatus();
}

absl::Status Parse(const Setting& setting, bool& value) {
  if (setting.value != "true" && setting.value != "false") {
    return InvalidArgument("option {} is \"{}\": it must be true or false", setting.key, setting.value);
  }
  value = setting.value == "true";
  return absl::OkStatus();
}

template <typename Number>
absl::Status Parse(const Setting& setting, Number& value) {
  const char* end = setting.value.data() + setting.value.size();
  Number parsed{};
  const auto result = std::from_chars(setting.value.data(), end, parsed);
  if (result.ec == std::errc() && result.ptr == end) {
    value = parsed;
    return absl::OkStatus();
  }
  return InvalidArgument("option {}: \"{}\" is not a valid number", setting.key, setting.value);
}

std::string Print(const std::string& value) { return value; }
template <typename Number>
std::string Print(const Number& value) {
  return fmt::format("{}", value);
}

// Levenshtein's distance, for "did you mean".
std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string NearestKey(const std::string& key) {
  const auto known = Describe(ServerOptions{});
  return std::min_element(
             known.begin(), known.end(),
             [&](const Setting& a, const Setting& b) { return EditDistance(a.key, key) < EditDistance(b.key, key); })
      ->key;
}

std::string EnvironmentName(const std::string& key) {
  std::string name = kEnvironmentPrefix;
  for (const char c : key) name += c == '.' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

absl::Status RequireAtLeast(const char* key, double value, double minimum) {
  if (value >= minimum && std::isfinite(value)) return absl::OkStatus();
  return InvalidArgument("option {} is {}: it must be at least {}", key, value, minimum);
}

constexpr double kCentury = 100 * 365 * 86'400.0;  // s

// Whether other machines can reach it: no socket in the file system, and no address of this machine alone.
bool IsReachedByOthers(std::string_view address) {
  if (address.empty() || address.starts_with("unix:")) return false;
  std::string_view host = address.substr(0, address.rfind(':'));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return host != "localhost" && host != "::1" && !host.starts_with("127.");
}

absl::Status ValidateTls(const ServerOptions& options) {
  const ServerOptions::Listen& listen = options.listen;
  if (listen.tls_certificate.empty() != listen.tls_key.empty()) {
    return InvalidArgument("listen.tls_certificate and listen.tls_key go together: only {} is set",
                           listen.tls_key.empty() ? "the certificate" : "the key");
  }
  if (listen.tls_certificate.empty() && !(listen.tls_client_authorities + listen.tls_revoked_directory).empty()) {
    return InvalidArgument(
        "listen.tls_client_authorities and listen.tls_revoked_directory need listen.tls_certificate");
  }
  if (listen.insecure) return absl::OkStatus();
  if (listen.tls_certificate.empty() && IsReachedByOthers(listen.address)) {
    return InvalidArgument(
        "listen.address is {}, which other machines reach, and there is no TLS: set listen.tls_certificate and"
        " listen.tls_key, or listen.insecure=true if the network is yours alone",
        listen.address);
  }
  if (IsReachedByOthers(options.metrics.address)) {
    return InvalidArgument(
        "metrics.address is {}, which other machines reach, and metrics have no TLS: set listen.insecure=true if the"
        " network is yours alone",
        options.metrics.address);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Apply(const Setting& setting, ServerOptions& options) {
  bool known = false;
  absl::Status status;
  VisitOptions(options, [&](const char* key, auto& value) {
    if (setting.key != key) return;
    known = true;
    status = Parse(setting, value);
  });
  if (!known) return InvalidArgument("unknown option {} (did you mean {}?)", setting.key, NearestKey(setting.key));
  return status;
}

std::vector<Setting> Describe(const ServerOptions& options) {
  std::vector<Setting> settings;
  VisitOptions(options, [&](const char* key, const auto& value) { settings.push_back({key, Print(value)}); });
  return settings;
}

absl::Status ApplyYaml(const std::string& text, const std::string& name, ServerOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const yaml_options::Values values, yaml_options::Load(text, name));
  for (const auto& [key, node] : values) {
    if (absl::Status status = Apply({key, node.Scalar()}, options); !status.ok()) {
      return WithContext(status, yaml_options::Location(name, node.Mark()));
    }
  }
  return absl::OkStatus();
}

absl::Status ApplyEnvironment(const std::vector<std::string>& environment, ServerOptions& options) {
  for (const std::string& variable : environment) {
    if (variable.rfind(kEnvironmentPrefix, 0) != 0) continue;
    const std::size_t equals = variable.find('=');
    const std::string name = variable.substr(0, equals);
    const auto known = Describe(options);
    const auto setting =
        std::find_if(known.begin(), known.end(), [&](const Setting& s) { return EnvironmentName(s.key) == name; });
    if (setting == known.end()) return InvalidArgument("environment variable {} names no option", name);
    const std::string value = equals == std::string::npos ? "" : variable.substr(equals + 1);
    if (absl::Status status = Apply({setting->key, value}, options); !status.ok()) return WithContext(status, name);
  }
  return absl::OkStatus();
}

int ServerOptions::Mapping::DefaultWorkers() {
  constexpr int kMost = 4;  // as many as the default of database.max_connections permits
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMost);
}

std::vector<std::string> ServerOptions::Warnings() const {
  std::vector<std::string> warnings;
  if (listen.tls_certificate.empty() && IsReachedByOthers(listen.address)) {
    warnings.push_back(
        fmt::format("{} is served without TLS: whoever reaches it can read and change all", listen.address));
  }
  if (IsReachedByOthers(metrics.address)) {
    warnings.push_back(fmt::format("metrics are served at {} without TLS", metrics.address));
  }
  return warnings;
}

absl::Status ServerOptions::Validate() const {
  ENFILADE_RETURN_IF_ERROR(ValidateTls(*this));
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("listen.grace_s", listen.grace_s, 0.0));
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("listen.workers", listen.workers, 1));
  ENFILADE_RETURN_IF_ERROR(
      RequireAtLeast("listen.max_message_bytes", static_cast<double>(listen.max_message_bytes), 2 << 20));
  if (listen.max_message_bytes > std::numeric_limits<int>::max()) {
    return InvalidArgument("option listen.max_message_bytes is {}: it must be below 2 GiB", listen.max_message_bytes);
  }
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("database.default_deadline_s", database.default_deadline_s, 0.001));
  if (!(graph.version_wait_s >= 0.0 && graph.version_wait_s <= 60.0)) {
    return InvalidArgument("option graph.version_wait_s is {}: expected 0 to 60", graph.version_wait_s);
  }
  for (const auto& [key, value] :
       {std::pair{"watches.max_per_site", watches.max_per_site}, std::pair{"watches.max_in_all", watches.max_in_all}}) {
    if (value < 1 || value > 100'000) return InvalidArgument("option {} is {}: expected 1 to 100000", key, value);
  }
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("ingest.writers", ingest.writers, 1));
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("mapping.workers", mapping.workers, 0));
  // One for each writer, two for each mapper, one each to receive changes of graphs, to optimise graphs, to judge doors
  // and to look for entered maps, and one for everything else.
  ENFILADE_RETURN_IF_ERROR(
      RequireAtLeast("database.max_connections", database.max_connections, ingest.writers + 2 * mapping.workers + 5));
  for (const auto& [key, value] :
       {std::pair{"ingest.stream_buffer_bytes", ingest.stream_buffer_bytes},
        std::pair{"ingest.total_buffer_bytes", ingest.total_buffer_bytes},
        std::pair{"ingest.transaction_bytes", ingest.transaction_bytes},
        std::pair{"mapping.parked_bytes", mapping.parked_bytes}, std::pair{"survey.cache_bytes", survey.cache_bytes},
        std::pair{"transfers.cache_bytes", transfers.cache_bytes},
        std::pair{"transfers.max_import_bytes", transfers.max_import_bytes},
        std::pair{"transfers.upload_memory_bytes", transfers.upload_memory_bytes},
        std::pair{"transfers.upload_disk_bytes", transfers.upload_disk_bytes}}) {
    ENFILADE_RETURN_IF_ERROR(RequireAtLeast(key, static_cast<double>(value), 1 << 20));
  }
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("mapping.lease_s", mapping.lease_s, 1.0));
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("mapping.checkpoint_interval_s", mapping.checkpoint_interval_s, 0.0));
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("mapping.revision_interval_s", mapping.revision_interval_s, 0.0));
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("mapping.pairing_window_s", mapping.pairing_window_s, 0.0));
  if (absl::Status status = closure.Validate(); !status.ok()) return WithContext(status, "option closure");
  if (!(survey.share >= 0.0 && survey.share <= 1.0)) {
    return InvalidArgument("survey.share is {}: expected 0 to 1", survey.share);
  }
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("survey.growth", survey.growth, 0.0));
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("survey.interval_s", survey.interval_s, 0.0));
  if (prior_maps.realign_s != 0.0 && !(prior_maps.realign_s >= 1.0 && prior_maps.realign_s <= kCentury)) {
    return InvalidArgument("prior_maps.realign_s is {}: expected 0, or 1 to {}, which is a century",
                           prior_maps.realign_s, kCentury);
  }
  ENFILADE_RETURN_IF_ERROR(RequireAtLeast("retention.interval_s", retention.interval_s, 0.1));
  if (!(retention.undo_s >= 0.0 && retention.undo_s <= kCentury)) {
    return InvalidArgument("retention.undo_s is {}: expected 0 to {}, which is a century", retention.undo_s, kCentury);
  }
  const double idle_s = retention.idle_session_s;
  if (idle_s != 0.0 && !(idle_s >= 60.0 && idle_s <= kCentury)) {
    return InvalidArgument("retention.idle_session_s is {}: expected 0, or 60 to {}, which is a century", idle_s,
                           kCentury);
  }
  for (const auto& [key, value] : {std::pair{"retention.deleted_session_s", retention.deleted_session_s},
                                   std::pair{"retention.unused_blob_s", retention.unused_blob_s}}) {
    if (!(value >= 60.0 && value <= kCentury)) {
      return InvalidArgument("{} is {}: expected 60 to {}, which is a century", key, value, kCentury);
    }
  }
  for (const char* level : {"trace", "debug", "info", "warn", "error"}) {
    if (log.level == level) {
      if (log.format == "text" || log.format == "json") return absl::OkStatus();
      return InvalidArgument("option log.format is \"{}\": it must be text or json", log.format);
    }
  }
  return InvalidArgument("option log.level is \"{}\": it must be trace, debug, info, warn or error", log.level);
}

}  // namespace enfilade::server
