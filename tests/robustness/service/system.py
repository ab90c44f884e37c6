# SPDX-License-Identifier: Apache-2.0
"""A private database cluster and a server, as processes of their own."""
import os
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
# Waits for the end of its input, which this process keeps open as long as it runs; then ends what is left.
GUARD = """read -r _; [ -s "$1/server.pid" ] && kill -KILL "$(cat "$1/server.pid")" 2>/dev/null
"$2" stop "$1/database" >/dev/null 2>&1; rm -rf "$1" """


class System:
    """Started on entering a `with` block, stopped on leaving it, and also if this process is killed."""

    def __init__(self, binaries, settings):
        self.binaries, self.settings = binaries, settings
        self.folder = Path(tempfile.mkdtemp(prefix="enfilade-robustness-"))
        self.folder.chmod(0o755)  # the database's owner enters it
        self.address = f"unix:{self.folder}/server.sock"
        self.log = self.folder / "server.log"
        self.url = ""
        self.server = None
        self.guard = subprocess.Popen(["sh", "-c", GUARD, "sh", self.folder, ROOT / "deploy/database/cluster"],
                                      stdin=subprocess.PIPE, start_new_session=True)

    def __enter__(self):
        self.start_database()
        try:
            self._deploy("database/migrate", "up", self.url)
            self.start_server()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if self.server and self.server.poll() is None:
            self.server.terminate()
            try:
                self.server.wait(timeout=60)
            except subprocess.TimeoutExpired:
                self.server.kill()
                self.server.wait()
        (self.folder / "server.pid").unlink(missing_ok=True)
        self.guard.communicate()

    def keep_log(self, file):
        """Copies the server's log."""
        shutil.copy(self.log, file)

    @staticmethod
    def _deploy(program, *arguments):
        done = subprocess.run([ROOT / "deploy" / program, *arguments], capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"{program} {' '.join(arguments)}:\n{done.stdout}{done.stderr}")
        return done.stdout

    def start_database(self):
        """Also after kill_database."""
        self.url = self._deploy("database/cluster", "start", str(self.folder / "database")).strip()

    def kill_database(self):
        """kill -9 of the postmaster. Its other processes end by themselves."""
        for folder in (self.folder / "database", Path(self._moved_to())):
            pid_file = folder / "data/postmaster.pid"
            if pid_file.exists():
                pid = int(pid_file.read_text().split()[0])
                os.kill(pid, signal.SIGKILL)
                while Path(f"/proc/{pid}").exists():  # until then PostgreSQL refuses to start again
                    time.sleep(0.01)
                return
        raise RuntimeError("no database is running")

    def _moved_to(self):
        moved = self.folder / "database/moved-to"
        return moved.read_text().strip() if moved.exists() else self.folder / "database"

    def kill_server(self):
        """kill -9."""
        (self.folder / "server.pid").unlink(missing_ok=True)  # another process may get its id
        self.server.kill()
        self.server.wait()

    def start_server(self):
        """Also after kill_server; returns when it answers."""
        settings = {**self.settings, "listen.address": self.address, "metrics.address": "",
                    "transfers.cache_directory": str(self.folder)}
        command = [str(self.binaries / "enfilade-server")]
        for key, value in settings.items():
            command += ["--set", f"{key}={value}"]
        with self.log.open("ab") as log:
            self.server = subprocess.Popen(command, stdout=log, stderr=log,
                                           env={**os.environ, "ENFILADE_SERVER_DATABASE_URL": self.url})
        (self.folder / "server.pid").write_text(str(self.server.pid))
        for _ in range(300):
            if self.server.poll() is not None:
                raise RuntimeError("the server did not start:\n" + self.log.read_text()[-2000:])
            if self._status_ok():
                return
            time.sleep(0.1)
        raise RuntimeError("the server is not ready:\n" + self.log.read_text()[-2000:])

    def _status_ok(self):
        return subprocess.run([self.binaries / "enfilade", "--server", self.address, "server", "status"],
                              capture_output=True, check=False).returncode == 0

    def tool(self, *arguments):
        """Runs `enfilade ARGUMENTS`."""
        command = [str(self.binaries / "enfilade"), "--quiet", "--server", self.address, *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"{' '.join(arguments)}:\n{done.stdout}{done.stderr}")

    def alive(self):
        """Whether the server still runs and answers."""
        return self.server.poll() is None and self._status_ok()

    def memory_mib(self, field="VmRSS"):
        """Of the server; VmHWM: its peak. 0 if it has ended."""
        try:
            for line in Path(f"/proc/{self.server.pid}/status").read_text().splitlines():
                if line.startswith(field + ":"):
                    return int(line.split()[1]) // 1024
        except OSError:
            pass
        return 0
