// SPDX-License-Identifier: Apache-2.0
#include "io/program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "core/base/error.h"

extern char** environ;

namespace enfilade::io {
namespace {

// Ours and the program's end of a stream.
class Channel {
 public:
  // Sockets, because writing to one whose other end is closed can be told not to raise SIGPIPE.
  bool Open() { return socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends_.data()) == 0; }
  ~Channel() {
    CloseOurs();
    CloseTheirs();
  }
  int ours() const { return ends_[0]; }
  int theirs() const { return ends_[1]; }
  void CloseOurs() { Close(ends_[0]); }
  void CloseTheirs() { Close(ends_[1]); }

 private:
  static void Close(int& end) {
    if (end >= 0) close(end);
    end = -1;
  }
  std::array<int, 2> ends_{-1, -1};
};

class RunningProgram {
 public:
  RunningProgram(std::string_view input, const ProgramLimits& limits)
      : input_(input), limits_(limits), deadline_(std::chrono::steady_clock::now() + limits.time) {}
  ~RunningProgram() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

  absl::Status Start(const std::vector<std::string>& command) {
    if (!in_.Open() || !out_.Open() || !err_.Open()) return Internal("{}: no socket: {}", command[0], strerror(errno));
    std::vector<char*> arguments;
    for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, in_.theirs(), 0);
    posix_spawn_file_actions_adddup2(&actions, out_.theirs(), 1);
    posix_spawn_file_actions_adddup2(&actions, err_.theirs(), 2);
    const int error = posix_spawnp(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) pid_ = -1;
    if (error == ENOENT) return NotFound("the program {} is not installed", command[0]);
    if (error != 0) return Internal("{} cannot be started: {}", command[0], strerror(error));
    for (Channel* channel : {&in_, &out_, &err_}) channel->CloseTheirs();
    return absl::OkStatus();
  }

  absl::Status Exchange(ProgramResult& result) {
    while (out_.ours() >= 0 || err_.ours() >= 0) {
      if (input_.empty()) in_.CloseOurs();
      std::array<pollfd, 3> polled{pollfd{in_.ours(), POLLOUT, 0}, pollfd{out_.ours(), POLLIN, 0},
                                   pollfd{err_.ours(), POLLIN, 0}};
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - std::chrono::steady_clock::now());
      if (left.count() <= 0)
        return absl::DeadlineExceededError(fmt::format("took longer than {} s", limits_.time.count()));
      if (poll(polled.data(), polled.size(), static_cast<int>(left.count()) + 1) < 0 && errno != EINTR) {
        return Internal("poll failed: {}", strerror(errno));
      }
      if (polled[0].revents != 0) Write();
      if (polled[1].revents != 0) Read(out_, result.output);
      if (polled[2].revents != 0) Read(err_, result.errors);
      if (result.output.size() + result.errors.size() > limits_.output_bytes) {
        return ResourceExhausted("wrote more than {} bytes", limits_.output_bytes);
      }
    }
    return absl::OkStatus();
  }

  absl::Status Wait(ProgramResult& result) {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    if (!WIFEXITED(status)) return Internal("was ended by signal {}", WTERMSIG(status));
    result.exit_code = WEXITSTATUS(status);
    return absl::OkStatus();
  }

 private:
  void Write() {
    const ssize_t written = send(in_.ours(), input_.data(), input_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (written > 0) input_.remove_prefix(static_cast<std::size_t>(written));
    if (written < 0 && errno != EAGAIN && errno != EINTR) input_ = {};  // it reads no more
  }

  static void Read(Channel& channel, std::string& to) {
    std::array<char, 65536> buffer;
    const ssize_t count = recv(channel.ours(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (count > 0) to.append(buffer.data(), static_cast<std::size_t>(count));
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) channel.CloseOurs();
  }

  std::string_view input_;
  const ProgramLimits limits_;
  const std::chrono::steady_clock::time_point deadline_;
  Channel in_, out_, err_;
  pid_t pid_ = -1;
};

}  // namespace

absl::StatusOr<ProgramResult> RunProgram(const std::vector<std::string>& command, std::string_view input,
                                         const ProgramLimits& limits) {
  RunningProgram program(input, limits);
  absl::Status status = program.Start(command);
  if (!status.ok()) return status;
  ProgramResult result;
  status = program.Exchange(result);
  if (status.ok()) status = program.Wait(result);
  if (!status.ok()) return WithContext(status, command[0]);
  return result;
}

}  // namespace enfilade::io
