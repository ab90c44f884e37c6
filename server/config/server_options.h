// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/closure/closure_options.h"

namespace enfilade::server {

// All options of the server, with units and defaults. They come from the YAML file, then the environment
// (ENFILADE_SERVER_DATABASE_URL sets database.url), then the command line (--set database.url=...); later ones win.
struct ServerOptions {
  struct Listen {
    // host:port or unix:/path. Port 0: any free port, which is logged. An address that other machines reach needs TLS,
    // or `insecure`.
    std::string address = "127.0.0.1:50051";
    // PEM files: the server's certificate, with those of the authorities between it and the root, and its key. With
    // them host:port is served by TLS only, unix:/path never. They are read again when they change.
    std::string tls_certificate;
    std::string tls_key;
    // PEM: whose certificates clients must have. Empty: clients need none.
    std::string tls_client_authorities;
    // A folder with the authorities' lists of revoked certificates (PEM), each named as `openssl rehash` does. Empty:
    // none.
    std::string tls_revoked_directory;
    // Serve other machines without TLS: whoever reaches the port can read and change all. Also for metrics.address,
    // which is always without TLS.
    bool insecure = false;
    // After SIGTERM: how long streams may take to finish, s.
    double grace_s = 10.0;
    // The largest message accepted, bytes: an image or cloud of 64 MiB with its frame.
    std::int64_t max_message_bytes = (64LL << 20) + (1LL << 20);
    // Threads for calls, which wait for the database.
    int workers = 8;
  } listen;

  struct Database {
    // libpq's connection URL or keywords; put the password into PGPASSWORD or ~/.pgpass.
    std::string url = "postgresql:///enfilade?host=/var/run/postgresql";
    int max_connections = 16;
    // For calls whose client sets no deadline, and for each step of an open-ended stream, s.
    double default_deadline_s = 30.0;
  } database;

  struct Graph {
    // How long a call waits for the version of a graph that its client has seen elsewhere, s, 0 to 60. Then it is
    // UNAVAILABLE.
    double version_wait_s = 2.0;
  } graph;

  struct Watches {
    // Streams of WatchGlobalPoses at the same time, of one site and in all, 1 to 100,000. More are refused.
    int max_per_site = 1000;
    int max_in_all = 4000;
  } watches;

  struct Ingest {
    // Threads that write batches, each on its own connection while it writes.
    int writers = 3;
    // The server stops reading a stream while this much of it is not yet stored, bytes.
    std::int64_t stream_buffer_bytes = 8LL << 20;
    // The same over all streams, bytes.
    std::int64_t total_buffer_bytes = 256LL << 20;
    // Batches of one stream that wait together are written in one transaction up to this size, bytes.
    std::int64_t transaction_bytes = 4LL << 20;
  } ingest;

  struct Mapping {
    // Sessions mapped at the same time by this process; 0: another replica maps. By default one for each processor, up
    // to four. They leave the processors to calls, streams and a database beside them.
    int workers = DefaultWorkers();
    static int DefaultWorkers();
    // How long a lease lasts if it is not renewed, s: another process takes over that long after a crash.
    double lease_s = 10.0;
    // Results and checkpoint are stored at least this often, s ...
    double checkpoint_interval_s = 5.0;
    // ... and a revision of the grid this often while a session is being recorded, s.
    double revision_interval_s = 20.0;
    // Memory for live sessions between two turns of mapping, so that they are not loaded from the database again,
    // bytes.
    std::int64_t parked_bytes = 512LL << 20;
    // A scan is paired with odometry at most this far from it in time, s.
    double pairing_window_s = 0.5;
    // A YAML file with SLAM options; empty: the defaults. They are the profile "indoor" and, with a longer range,
    // "outdoor".
    std::string slam_options_file;
    // A folder with SLAM options in files NAME.yaml: more profiles for maps to name, or replacements for these two.
    // Empty: none.
    std::string slam_profiles_directory;
  } mapping;

  // How robots' door reports are judged: core/closure/closure_options.h.
  closure::DoorClosureOptions closure;

  struct Survey {
    // The largest share of a processor for surveys, which make each room one map (docs/survey.md), 0 to 1. 0: sites are
    // not surveyed.
    double share = 0.25;
    // While robots record at a site, it is surveyed again once as many sessions are new as this share of those that the
    // last survey has seen, and at the latest this long after it, s. As soon as a robot records no more, it is
    // surveyed.
    double growth = 1.0;
    double interval_s = 300.0;
    // Memory for what the last surveys have mapped, so that the next one goes on from there, bytes.
    std::int64_t cache_bytes = 512LL << 20;
  } survey;

  struct Transfers {
    // Where rendered files are kept for the next download; empty: a new folder under the system's temporary one.
    std::string cache_directory;
    // The size above which the oldest files are removed, bytes.
    std::int64_t cache_bytes = 2LL << 30;
    // The largest import, bytes.
    std::int64_t max_import_bytes = 1LL << 30;
    // What uploads under way may hold in memory and on disk, bytes. Beyond that they are refused for a while.
    std::int64_t upload_memory_bytes = 128LL << 20;
    std::int64_t upload_disk_bytes = 8LL << 30;
    // Where large ones are kept meanwhile, in files that nobody else sees; empty: the system's folder for temporary
    // files.
    std::string upload_directory;
  } transfers;

  struct PriorMaps {
    // Plans in use are aligned again when robots have mapped more since, each at most this often, s, 1 or more. It
    // takes seconds of a processor each time. 0: never.
    double realign_s = 600.0;
  } prior_maps;

  struct Retention {
    // How often what is past its retention is deleted, s: what sites say, and what follows.
    double interval_s = 300.0;
    // How long merges and splits of maps can be undone, s, up to a century. Afterwards what undoing needs is deleted.
    double undo_s = 30 * 86'400.0;
    // A session that nobody finishes is closed when it has got no record for this long, s, a minute to a century; 0:
    // never. Its robot cannot send more records of it then, so let it be longer than robots are away.
    double idle_session_s = 30 * 86'400.0;
    // How long it is remembered that a session was deleted, s, a minute to a century: late records of it are refused,
    // and its id is not used again. Let it be longer than robots are away.
    double deleted_session_s = 30 * 86'400.0;
    // How long a blob (an image, a cloud, a tile) stays that nothing refers to, s, a minute to a century. After an
    // outage, a robot sends the record that refers to a blob long after the blob.
    double unused_blob_s = 86'400.0;
  } retention;

  struct Metrics {
    // host:port for Prometheus; empty: not served. An address that other machines reach needs listen.insecure.
    std::string address = "127.0.0.1:9464";
  } metrics;

  struct Log {
    std::string level = "info";   // trace, debug, info, warn, error
    std::string format = "text";  // text or json, one object per line
  } log;

  // INVALID_ARGUMENT naming the key.
  absl::Status Validate() const;
  // What is unsafe about them, for people: a sentence each.
  std::vector<std::string> Warnings() const;
};

// One option by its key, for example "database.url".
struct Setting {
  std::string key;
  std::string value;
};

// INVALID_ARGUMENT for an unknown key, with the most similar known one, or for a value of the wrong type.
absl::Status Apply(const Setting& setting, ServerOptions& options);

// Every key with its value, in order: for --print-config and the documentation.
std::vector<Setting> Describe(const ServerOptions& options);

// `text` is the content of the YAML file `name`. Errors name the line.
absl::Status ApplyYaml(const std::string& text, const std::string& name, ServerOptions& options);

// `environment`: "NAME=value", as in environ. INVALID_ARGUMENT for a variable that begins with ENFILADE_SERVER_ but
// names no key.
absl::Status ApplyEnvironment(const std::vector<std::string>& environment, ServerOptions& options);

}  // namespace enfilade::server
