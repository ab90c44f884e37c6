// SPDX-License-Identifier: Apache-2.0
#include "io/tls/reloaded_tls_files.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "io/file.h"

namespace enfilade::io {
namespace {

namespace fs = std::filesystem;

constexpr auto kInterval = std::chrono::milliseconds(500);
constexpr char kCertificate[] = "certificate.pem";
constexpr char kKey[] = "key.pem";
constexpr char kAuthorities[] = "authorities.pem";
constexpr char kCurrent[] = "current";  // a link to the folder of the last good set

absl::Status WriteIfAny(const fs::path& path, const std::string& content) {
  return content.empty() ? absl::OkStatus() : WriteFile(path, content);
}

// What tells a change of the files in `folder`, in PEM a comment. Files that come and go meanwhile are seen next time.
std::string Listing(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator file(folder, error); !error && file != fs::directory_iterator(); file.increment(error)) {
    const auto time = fs::last_write_time(file->path(), error).time_since_epoch().count();
    files.push_back(
        fmt::format("# {} {} {}\n", file->path().filename().string(), fs::file_size(file->path(), error), time));
    error.clear();
  }
  std::sort(files.begin(), files.end());
  return fmt::format("{}", fmt::join(files, ""));
}

// Where systemd gives the service a folder of its own, else the folder for temporary files.
fs::path ParentFolder() {
  const char* own = std::getenv("RUNTIME_DIRECTORY");
  return own != nullptr && *own != '\0' ? fs::path(own) : fs::temp_directory_path();
}

}  // namespace

absl::StatusOr<std::unique_ptr<ReloadedTlsFiles>> ReloadedTlsFiles::Open(const TlsParts& paths,
                                                                         const std::string& revoked,
                                                                         OnReload on_reload) {
  const std::string lists = Listing(revoked);
  ENFILADE_ASSIGN_OR_RETURN(const CheckedTls tls, ReadTlsFiles(paths));
  std::string folder = ParentFolder() / "enfilade-tls-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) return FileError(folder, "cannot be made", errno);
  std::unique_ptr<ReloadedTlsFiles> files(new ReloadedTlsFiles(paths, revoked, std::move(on_reload), folder));
  ENFILADE_RETURN_IF_ERROR(files->Publish(tls, lists));
  files->expires_ = tls.expires;
  files->thread_ = std::thread([self = files.get()] { self->Watch(); });
  return files;
}

ReloadedTlsFiles::ReloadedTlsFiles(TlsParts sources, std::string revoked, OnReload on_reload, fs::path folder)
    : sources_(std::move(sources)),
      revoked_(std::move(revoked)),
      on_reload_(std::move(on_reload)),
      folder_(std::move(folder)) {}

ReloadedTlsFiles::~ReloadedTlsFiles() {
  {
    const MutexLock lock(mutex_);
    stop_ = true;
  }
  stopped_.NotifyAll();
  if (thread_.joinable()) thread_.join();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

TlsParts ReloadedTlsFiles::paths() const {
  const fs::path current = folder_ / kCurrent;
  const auto path = [&](const std::string& source, const char* name) {
    return source.empty() ? std::string() : (current / name).string();
  };
  return {.certificate = path(sources_.certificate, kCertificate),
          .key = path(sources_.key, kKey),
          .authorities = path(sources_.authorities, kAuthorities)};
}

absl::Status ReloadedTlsFiles::Publish(const CheckedTls& tls, const std::string& lists) {
  const fs::path next = folder_ / std::to_string(++generation_);
  std::error_code error;
  fs::create_directory(next, error);
  if (error) return FileError(next, "cannot be made", error.value());
  ENFILADE_RETURN_IF_ERROR(
      WriteIfAny(next / kCertificate, tls.content.certificate.empty() ? "" : lists + tls.content.certificate));
  ENFILADE_RETURN_IF_ERROR(WriteIfAny(next / kKey, tls.content.key));
  ENFILADE_RETURN_IF_ERROR(WriteIfAny(next / kAuthorities, tls.content.authorities));
  const fs::path link = folder_ / "next";
  fs::remove(link, error);
  fs::create_directory_symlink(next.filename(), link, error);
  if (!error) fs::rename(link, folder_ / kCurrent, error);
  if (error) return FileError(link, "cannot be put in place", error.value());
  published_ = tls.content;
  published_lists_ = lists;
  // Who reads the set before may not be done; the one before that has been left for at least a second.
  fs::remove_all(folder_ / std::to_string(generation_ - 2), error);
  return absl::OkStatus();
}

bool ReloadedTlsFiles::WaitForNextLook() {
  const MutexLock lock(mutex_);
  const auto next = std::chrono::steady_clock::now() + kInterval;
  while (!stop_ && std::chrono::steady_clock::now() < next) stopped_.WaitUntil(mutex_, next);
  return !stop_;
}

void ReloadedTlsFiles::Watch() {
  while (WaitForNextLook()) LookForChanges();
}

void ReloadedTlsFiles::LookForChanges() {
  const std::string lists = Listing(revoked_);
  absl::StatusOr<CheckedTls> tls = ReadTlsFiles(sources_);
  if (tls.ok() && tls->content == published_ && lists == published_lists_) {
    last_error_.clear();
    return;
  }
  if (tls.ok()) {
    if (absl::Status published = Publish(*tls, lists); !published.ok()) tls = std::move(published);
  }
  const std::string said = tls.ok() ? "" : std::string(tls.status().message());
  if (!tls.ok() && said == last_error_) return;  // has been told
  last_error_ = said;
  if (on_reload_) on_reload_(tls);
}

}  // namespace enfilade::io
