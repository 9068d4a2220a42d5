# SPDX-License-Identifier: MIT
"""What befalls the disk under a daemon: it is full, it turns read-only, another process locks the
database, the file is damaged before the start. Refused clearly or kept: of what was acknowledged
nothing is lost. The disks are mounted in a mount namespace of the test's own."""
import collections
import itertools
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from daemon import (  # noqa: E402
    BUILD, Daemon, Tap, argument_of, expect, expect_problem, expect_sound_log, saddle)

DISK_BYTES = 64 << 20
BALLAST_BYTES = 56 << 20  # what is left is less than the result of LARGE
LARGE = 0.02
SMALL_BYTES = 100000  # less than the result of a drape of spacing 0.21
RESERVE_BYTES = 500 << 10  # about what the store keeps free
LOCK_SECONDS = 10  # twice what the store waits for a lock
PATIENCE_SECONDS = 60
PROBE_SECONDS = 8  # what the manifests in deploy/ give a probe of /healthz
CROWD = 32
RETRY_SECONDS = 0.5  # between two attempts whose result the store could not take


def enter_namespace():
    """Starts this program again where it may mount; False when that is not to be had."""
    if os.environ.get("DISK_NAMESPACE"):
        return True
    unshare = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]
    if subprocess.run([*unshare, "true"], capture_output=True, check=False).returncode != 0:
        return False
    os.environ["DISK_NAMESPACE"] = "1"
    os.execvp(unshare[0], [*unshare, sys.executable, *sys.argv])


def command(*words):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    expect(done.returncode == 0, f"{' '.join(words)}: {done.stderr}")


class Disk(Daemon):
    """A daemon whose data folder is a disk of its own."""

    def __init__(self, *flags, mounted=True):
        super().__init__("--workers", "1", *flags)
        self.data = os.path.join(self.home, "data")
        self.database = os.path.join(self.data, "draped.db")
        self.spacing = itertools.count(2000)  # in units of 0.1 mm: every drape is another
        self.acknowledged = []
        os.mkdir(self.data)
        if mounted:
            command("mount", "-t", "tmpfs", "-o", f"size={DISK_BYTES},mode=700", "disk", self.data)

    def remove(self):
        if self.process:
            self.kill()
        subprocess.run(["umount", "-l", self.data], capture_output=True, check=False)
        super().remove()

    def drape(self, spacing=None):
        """Submits a new drape. The problem's detail when it is refused, None when it is taken."""
        request = saddle(spacing or next(self.spacing) * 1e-4)
        status, headers, body = self.submit(request)
        if status == 202:
            self.acknowledged.append(json.loads(body)["id"])
            return None
        expect(status == 503 and "retry-after" in headers, f"submit is {status}: {body[:200]}")
        expect_problem(status, headers, body, "unavailable")
        return json.loads(body)["detail"]

    def expect_alive(self, ready, cause=""):
        expect(self.call("GET", "/healthz")[0] == 200, "/healthz")
        status, headers, body = self.call("GET", "/readyz")
        expect(status == (200 if ready else 503), f"/readyz is {status}: {body[:200]}")
        metrics = self.call("GET", "/metrics")[2].decode()
        expect(f"\ndraped_store_up {int(ready)}\n" in metrics, "draped_store_up is not that of /readyz")
        if not ready:
            expect_problem(status, headers, body, "unavailable")
            expect(cause in json.loads(body)["detail"], f"/readyz does not say {cause!r}: {body}")

    def wait_ready(self):
        end = time.monotonic() + PATIENCE_SECONDS
        while self.call("GET", "/readyz")[0] != 200:
            expect(time.monotonic() < end, f"it does not go on: {self.log_tail()}")
            time.sleep(0.1)

    def results(self):
        """Of every drape that was acknowledged; all of them succeed in the end."""
        found = {}
        for job in self.acknowledged:
            for _ in range(PATIENCE_SECONDS // 20):
                state = self.get_json(f"/v1/drapes/{job}?wait=20")
                if state["finished"]:
                    break
            expect(state["status"] == "succeeded", state)
            status, headers, _ = self.call("GET", f"/v1/drapes/{job}/result?format=csv")
            expect(status == 200, f"the result of {job} is {status}")
            found[job] = headers["etag"]
        return found

    def expect_results(self, wanted):
        for job, tag in wanted.items():
            status, headers, body = self.call("GET", f"/v1/drapes/{job}/result?format=csv")
            expect(status == 200 and headers["etag"] == tag, f"{job} is {status}: {body[:200]}")

    def expect_kept(self, before):
        """All is there, also for a new process."""
        expect(self.drape() is None, "it takes nothing new")
        after = self.results()
        expect(before.items() <= after.items(), "a result has changed")
        self.end_well()
        self.start()
        expect(self.results() == after, "another process finds other results")
        self.end_well()
        expect_sound_log(self)

    def refused_start(self):
        """What it says when it does not start."""
        done = subprocess.run([f"{BUILD}/draped", "--listen", "127.0.0.1:0", "--data", self.data],
                              capture_output=True, text=True, timeout=60, check=False)
        expect(done.returncode == 1 and not done.stdout, f"{done.returncode} {done.stdout}")
        return done.stderr


def fill(path, most=None):
    """Writes until the disk is full or there are `most` bytes."""
    block = bytes(4096)
    try:
        with open(path, "wb", buffering=0) as file:
            while most is None or file.tell() < most:
                if file.write(block) < len(block):
                    return
    except OSError:
        return


def wait_for_log(disk, least):
    """Until what was written is in the database as well: the log on its own would fill the disk."""
    begun = time.monotonic()
    while os.path.getsize(disk.database) < least:
        expect(time.monotonic() < begun + PATIENCE_SECONDS, "the log is not taken")
        time.sleep(0.05)


def wait_for_attempts(disk, job, wanted):
    """Tried again and again while its result finds no room, but not without a pause."""
    begun, state = time.monotonic(), {"attempts": 0}
    while state["attempts"] < wanted:
        expect(time.monotonic() < begun + PATIENCE_SECONDS, state)
        time.sleep(0.05)
        state = disk.get_json(f"/v1/drapes/{job}")
        expect(state["status"] in ("queued", "running"), state)
    most = 2 + (time.monotonic() - begun) / RETRY_SECONDS
    expect(state["attempts"] <= most, f"{state['attempts']} attempts, {most:.0f} are enough")


def refuse_for(disk, seconds):
    """While the disk is as it is, it reads and says what is wrong; the causes it gives."""
    causes = set()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        causes.add(disk.drape())
        expect(disk.call("GET", "/healthz")[0] == 200, "/healthz")
        expect(disk.call("GET", "/v1/drapes")[0] == 200, "it does not read")
        time.sleep(0.05)
    return causes


def test_full_start():
    disk = Disk()
    try:
        rest = os.path.join(disk.data, "rest")
        fill(rest)
        said = disk.refused_start()
        print(f"# {json.loads(said.splitlines()[-1])['why']}")
        expect(disk.database in said and "disk is full" in said, said)
        os.unlink(rest)
        disk.start()
        disk.expect_kept({})
    finally:
        disk.remove()


def submit_until(disk, until, causes):
    while time.monotonic() < until:
        try:
            causes[disk.drape()] += 1
        except Exception as error:
            causes[repr(error)] += 1


def test_full():
    disk = Disk()
    try:
        ballast, rest = os.path.join(disk.data, "ballast"), os.path.join(disk.data, "rest")
        fill(ballast, BALLAST_BYTES)
        disk.start()
        for _ in range(4):
            expect(disk.drape(0.2 + next(disk.spacing) * 1e-6) is None, "refused with room left")
        keyed = disk.submit(saddle(0.21), Idempotency_Key="once")
        expect(keyed[0] == 202, "refused with room left")
        disk.acknowledged.append(json.loads(keyed[2])["id"])
        before = disk.results()
        wait_for_log(disk, 5 * SMALL_BYTES)
        expect(disk.drape(LARGE) is None, "refused with room left")
        wait_for_attempts(disk, disk.acknowledged[-1], 4)
        fill(rest)
        causes = refuse_for(disk, 3)
        print(f"# {len(disk.acknowledged)} drapes acknowledged, then: {causes}")
        expect("the store is out of disk space" in causes, "the cause is not named")
        disk.expect_alive(False, "disk space")
        disk.expect_results(before)
        again = disk.submit(saddle(0.21), Idempotency_Key="once")
        expect(again[0] == 202 and json.loads(again[2])["id"] == disk.acknowledged[4],
               f"a repeat is {again[0]}: {again[2][:200]}")
        os.unlink(ballast)
        os.unlink(rest)
        disk.wait_ready()
        disk.expect_kept(before)
    finally:
        disk.remove()


def free_bytes(disk):
    room = os.statvfs(disk.data)
    return room.f_bavail * room.f_frsize


def test_reserve():
    """What is accepted and stored leaves its reserve for small changes, also when all of the log is in
    the database."""
    disk = Disk("--drain-timeout", "1")
    try:
        fill(os.path.join(disk.data, "ballast"), BALLAST_BYTES - (8 << 20))
        disk.start()
        stored = True
        while stored and disk.drape(0.06 + next(disk.spacing) * 1e-7) is None:
            state = disk.get_json(f"/v1/drapes/{disk.acknowledged[-1]}?wait=3")
            stored = state["status"] == "succeeded"  # or it has found no room for its result
        disk.end_well()  # with all of the log in the database
        print(f"# {len(disk.acknowledged)} drapes, {free_bytes(disk)} bytes left")
        expect(free_bytes(disk) >= RESERVE_BYTES, "the reserve is used up")
    finally:
        disk.remove()


def test_read_only_start():
    """A file system with files open for writing does not turn read-only on request; the start is
    where it is met."""
    disk = Disk()
    try:
        disk.start()
        expect(disk.drape() is None, "refused")
        before = disk.results()
        disk.end_well()
        command("mount", "-o", "remount,bind,ro", disk.data)
        said = disk.refused_start()
        expect(disk.data in said and "Read-only file system" in said, said)
        command("mount", "-o", "remount,bind,rw", disk.data)
        disk.start()
        disk.expect_kept(before)
    finally:
        disk.remove()


def mount_image(disk):
    """A file system that the kernel can take away while files are open; False without a loop
    device."""
    image = os.path.join(disk.home, "image")
    with open(image, "wb") as file:
        file.truncate(DISK_BYTES)
    return all(subprocess.run(words, capture_output=True, check=False).returncode == 0
               for words in (["/sbin/mkfs.ext4", "-q", image],
                             ["mount", "-o", "loop", image, disk.data]))


def test_broken_disk():
    """What ext4 does when the device fails: every file turns read-only, open ones too."""
    disk = Disk(mounted=False)
    try:
        if not mount_image(disk):
            print("# SKIP no loop device, or not root")
            return
        disk.start()
        for _ in range(3):
            expect(disk.drape() is None, "refused")
        before = disk.results()
        command("mount", "-o", "remount,abort", disk.data)
        causes = refuse_for(disk, 2)
        expect(None not in causes, "acknowledged on a disk that takes nothing")
        print(f"# refused: {causes}")
        disk.expect_alive(False, "the store is")
        disk.expect_results(before)
        disk.end_well()
        said = disk.refused_start()
        expect(disk.data in said, said)
        command("umount", disk.data)
        command("mount", "-o", "loop", os.path.join(disk.home, "image"), disk.data)
        disk.start()
        disk.expect_kept(before)
    finally:
        disk.remove()


def test_locked():
    """More callers than the daemon has threads: they are refused while the lock lasts, and the
    probes of its health do not wait behind them."""
    disk = Disk(mounted=False)
    other, crowd, causes = None, [], collections.Counter()
    try:
        disk.start()
        expect(disk.drape() is None, "refused")
        before = disk.results()
        other = sqlite3.connect(disk.database, isolation_level=None)
        other.execute("BEGIN EXCLUSIVE")
        until = time.monotonic() + LOCK_SECONDS
        crowd = [threading.Thread(target=submit_until, args=(disk, until, causes))
                 for _ in range(CROWD)]
        for thread in crowd:
            thread.start()
        while time.monotonic() < until:
            expect(disk.call("GET", "/healthz", timeout=PROBE_SECONDS)[0] == 200, "/healthz")
            expect(disk.call("GET", "/v1/drapes", timeout=PROBE_SECONDS)[0] == 200, "no reads")
            time.sleep(0.1)
        for thread in crowd:
            thread.join()
        disk.expect_alive(False, "busy")
        other.execute("ROLLBACK")
        print(f"# {dict(causes)}")
        expect(set(causes) == {"the store is busy"}, causes)
        disk.wait_ready()
        disk.expect_kept(before)
    finally:
        for thread in crowd:
            thread.join()
        if other:
            other.close()
        disk.remove()


def wait_not_ready(disk):
    """A contract: 2 s at the most; here a busy machine has longer."""
    begun = time.monotonic()
    while disk.call("GET", "/readyz")[0] == 200:
        expect(time.monotonic() < begun + PATIENCE_SECONDS, "still ready")
        time.sleep(0.02)
    print(f"# not ready after {time.monotonic() - begun:.2f} s")


def test_moved():
    """The data folder is moved away under a daemon that is busy, and back: what was acknowledged in
    between, if anything, is in the folder."""
    disk = Disk(mounted=False)
    crowd, causes = [], collections.Counter()
    away = disk.data + ".away"
    try:
        disk.start()
        expect(disk.drape() is None, "refused")
        before = disk.results()
        until = time.monotonic() + 3
        crowd = [threading.Thread(target=submit_until, args=(disk, until, causes))
                 for _ in range(4)]
        for thread in crowd:
            thread.start()
        time.sleep(1)
        os.rename(disk.data, away)
        wait_not_ready(disk)
        for thread in crowd:
            thread.join()
        print(f"# {dict(causes)}")
        expect(set(causes) == {None, "the store is missing from its path"}, causes)
        disk.expect_alive(False, "missing from its path")
        expect(disk.drape() is not None, "acknowledged into a folder that is not there")
        disk.expect_results(before)  # what it has open it still reads
        os.rename(away, disk.data)
        disk.wait_ready()
        disk.expect_kept(before)
        with open(disk.log_path) as log:
            events = [json.loads(line)["event"] for line in log]
        expect(events.count("store_file_gone") == 1 and events.count("store_file_back") == 1,
               "the log does not say it once")
    finally:
        for thread in crowd:
            thread.join()
        disk.remove()


def test_removed():
    """rm -r of the data folder, and another database in its place: nothing is acknowledged."""
    disk = Disk(mounted=False)
    try:
        disk.start()
        expect(disk.drape() is None, "refused")
        disk.results()
        shutil.copytree(disk.data, disk.data + ".copy")
        shutil.rmtree(disk.data)
        expect(disk.drape() is not None, "acknowledged into a file that was removed")
        wait_not_ready(disk)
        os.rename(disk.data + ".copy", disk.data)
        expect(disk.drape() is not None, "acknowledged into a file that was replaced")
        disk.expect_alive(False, "missing from its path")
        disk.end_well()
    finally:
        disk.remove()


def workers_of(disk):
    return [pid for pid in disk.children() if argument_of(pid) == "worker"]


def test_waited_in_vain():
    """A caller waits for a drape that does not end in time. It is promised the drape only then: not
    when the data folder has gone meanwhile."""
    disk, answers, stopped = Disk(mounted=False), [], []
    away = disk.data + ".away"
    try:
        disk.start()
        expect(disk.drape() is None, "refused")
        before = disk.results()
        stopped = workers_of(disk)
        expect(stopped, "there is no worker")
        for pid in stopped:
            os.kill(pid, signal.SIGSTOP)
        caller = threading.Thread(
            target=lambda: answers.append(disk.submit(saddle(0.3), Prefer="wait=3")))
        caller.start()
        end = time.monotonic() + PATIENCE_SECONDS
        while len(disk.get_json("/v1/drapes")["drapes"]) < 2:
            expect(time.monotonic() < end, "it is not submitted")
            time.sleep(0.02)
        os.rename(disk.data, away)
        caller.join()
        expect_problem(*answers[0], "unavailable")
        os.rename(away, disk.data)
        for pid in stopped:
            os.kill(pid, signal.SIGCONT)
        disk.wait_ready()
        disk.expect_kept(before)
    finally:
        for pid in stopped:
            if argument_of(pid):
                os.kill(pid, signal.SIGCONT)
        disk.remove()


def overwrite(path, offset, length):
    with open(path, "r+b") as file:
        file.seek(offset)
        file.write(b"\xa5" * length)


def test_damaged():
    """A start on a damaged file is refused, with its name and what to do; the copy of it serves."""
    disk = Disk(mounted=False)
    try:
        disk.start()
        for _ in range(20):
            expect(disk.drape() is None, "refused")
        before = disk.results()
        disk.end_well()
        with open(disk.database, "rb") as file:
            whole = file.read()
        damages = {
            "header": lambda: overwrite(disk.database, 0, 100),
            "first page": lambda: overwrite(disk.database, 100, 8000),
            "all but the first page": lambda: overwrite(disk.database, 8192, len(whole) - 8192),
            "cut off": lambda: os.truncate(disk.database, len(whole) // 2),
        }
        for name, damage in damages.items():
            damage()
            said = disk.refused_start()
            expect(disk.database in said and "restore it from a backup" in said, f"{name}: {said}")
            with open(disk.database, "wb") as file:
                file.write(whole)
        disk.start()
        disk.expect_kept(before)
    finally:
        disk.remove()


def main():
    tap = Tap()
    if not enter_namespace():
        print("ok 1 - disk # SKIP no mount namespace (unshare is refused)\n1..1")
        return
    tap.run("disk: a full one costs no acknowledged drape, and it goes on by itself", test_full)
    tap.run("disk: what it stores leaves a reserve, with the log in the database", test_reserve)
    tap.run("disk: no start on a full one", test_full_start)
    tap.run("disk: no start on a read-only one", test_read_only_start)
    tap.run("disk: one that fails under the daemon is told, and reads go on", test_broken_disk)
    tap.run("disk: a locked database is told, and then it goes on", test_locked)
    tap.run("disk: a call that has waited in vain is not promised a drape that went with the disk",
            test_waited_in_vain)
    tap.run("disk: a data folder that is moved away is missed at once, and serves when it is back",
            test_moved)
    tap.run("disk: nothing is acknowledged into a folder that was removed", test_removed)
    tap.run("disk: no start on a damaged database, which is named with the remedy", test_damaged)
    tap.finish()


if __name__ == "__main__":
    main()
