// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "io/tls/tls_files.h"

namespace enfilade::io {

// Copies of TLS files that change only from one whole, valid set to the next, for gRPC's
// FileWatcherCertificateProvider: that takes whatever it finds, so that a file that is half written, or the key of
// another certificate, would end all handshakes. The files are read twice a second; a set that does not pass
// ReadTlsFiles is reported, and the last good one stays. The copies are in a folder of the process's own, which only
// its user may read.
class ReloadedTlsFiles {
 public:
  // What became of a change of the files: OK, or why the last good set stays.
  using OnReload = std::function<void(const absl::StatusOr<CheckedTls>& tls)>;

  // `revoked`: a folder with lists of revoked certificates, empty: none. gRPC reads it when it gets a new set, so that
  // a change in it makes one. `on_reload` is called in another thread, once for each change. Errors are those of
  // ReadTlsFiles, or of the folder of the copies.
  static absl::StatusOr<std::unique_ptr<ReloadedTlsFiles>> Open(const TlsParts& paths, const std::string& revoked,
                                                                OnReload on_reload);
  ~ReloadedTlsFiles();
  ReloadedTlsFiles(const ReloadedTlsFiles&) = delete;
  ReloadedTlsFiles& operator=(const ReloadedTlsFiles&) = delete;

  // Of the copies. Empty where there is no such file.
  TlsParts paths() const;
  // Of the set with which it began.
  std::chrono::system_clock::time_point expires() const { return expires_; }

 private:
  ReloadedTlsFiles(TlsParts sources, std::string revoked, OnReload on_reload, std::filesystem::path folder);
  absl::Status Publish(const CheckedTls& tls, const std::string& lists);
  void Watch();
  bool WaitForNextLook();  // false: stop
  void LookForChanges();

  const TlsParts sources_;
  const std::string revoked_;
  const OnReload on_reload_;
  const std::filesystem::path folder_;
  int generation_ = 0;
  TlsParts published_;
  std::string published_lists_;  // names, sizes and times of the files in revoked_
  std::string last_error_;
  std::chrono::system_clock::time_point expires_;
  Mutex mutex_;
  CondVar stopped_;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace enfilade::io
