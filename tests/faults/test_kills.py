# SPDX-License-Identifier: MIT
"""What befalls processes: SIGKILL of the daemon or of workers at random under load, a worker that
is stopped beyond its lease's renewal, SIGTERM under load. DRAPED_SEED repeats the kills; LONG=1 is
make soak."""
import json
import os
import signal
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from daemon import LONG, Daemon, Tap, expect, expect_sound_log, saddle, seed  # noqa: E402
from ledger import Ledger  # noqa: E402

KILLS = 200 if LONG else 12
CLIENTS = 4
SETTLE_SECONDS = 120
SLOW = 0.003  # a spacing
# So that no job is taken up again because its lease has ended: what is killed has to be noticed.
LEASE = ("--lease", str(10 * SETTLE_SECONDS))


def kill_workers(daemon, random):
    for worker in daemon.children():
        if random.random() < 0.7:
            try:
                os.kill(worker, signal.SIGKILL)
            except ProcessLookupError:
                continue


def test_kills():
    random = seed()
    daemon = Daemon("--workers", "2", *LEASE).start()
    ledger = None
    try:
        port = daemon.port
        ledger = Ledger(daemon, CLIENTS, random)
        count = {"daemon": 0, "workers": 0}
        for _ in range(KILLS):
            time.sleep(0.05 + 0.4 * random.random())
            if random.random() < 0.5:
                count["workers"] += 1
                kill_workers(daemon, random)
            else:
                count["daemon"] += 1
                daemon.kill()
                daemon.start(port=port)
        ledger.stop()
        ledger.settle(SETTLE_SECONDS)
        print(f"# {count['daemon']} kills of the daemon, {count['workers']} of workers: "
              f"{ledger.summary()}")
        expect(ledger.jobs and ledger.collected, "there was no load")
        daemon.end_well()
    finally:
        if ledger:
            ledger.stop()
        daemon.remove()


def test_poison_job_ends():
    """A job whose worker dies again and again fails by itself, and the next job runs."""
    daemon = Daemon("--workers", "1").start()
    try:
        status, _, body = daemon.submit(saddle(0.003))
        expect(status == 202, body)
        job = daemon.get_json("/v1/drapes")["drapes"][0]["id"]
        end = time.monotonic() + 90
        while (state := daemon.get_json(f"/v1/drapes/{job}"))["status"] in ("queued", "running"):
            expect(time.monotonic() < end, state)
            if state["status"] == "running":
                for worker in daemon.workers():
                    os.kill(worker, signal.SIGKILL)
            time.sleep(0.05)
        expect(state["status"] == "failed" and state["attempts"] == 3, state)
        expect(state["error"]["type"] == "/problems/solver-crashed", state)
        status, _, body = daemon.call("GET", f"/v1/drapes/{job}/result")
        expect(status == state["error"]["status"] and b"solver-crashed" in body, body[:200])
        next_job = daemon.submit(saddle(0.3), Prefer="wait=40")
        expect(next_job[0] == 200, next_job[2][:300])
        daemon.end_well()
    finally:
        daemon.remove()


def stopped_at(daemon, job):
    """Stops all workers while the job is running on one of them."""
    end = time.monotonic() + 30
    while daemon.get_json(f"/v1/drapes/{job}")["status"] == "queued":
        expect(time.monotonic() < end, "it does not begin")
    workers = daemon.workers()
    for worker in workers:
        os.kill(worker, signal.SIGSTOP)
    return workers


def test_stopped_worker():
    """A worker under SIGSTOP runs out of time; its job ends as such, others go on meanwhile, and
    what it says when it wakes up is not believed: it is dead by then. The drape is one that takes
    far longer than this test on any machine."""
    daemon = Daemon("--workers", "2", "--job-timeout", "6").start()
    try:
        status, _, body = daemon.submit(saddle(SLOW))
        expect(status == 202, body)
        job = json.loads(body)["id"]
        workers = stopped_at(daemon, job)
        expect(daemon.get_json(f"/v1/drapes/{job}")["status"] == "running", "it ended before")
        state = daemon.get_json(f"/v1/drapes/{job}?wait=40")
        expect(state["status"] == "failed", state)
        expect(state["error"]["type"] == "/problems/job-timeout", state)
        for worker in workers:
            try:
                os.kill(worker, signal.SIGCONT)
            except ProcessLookupError:
                continue  # killed, as it should be
        after = daemon.submit(saddle(0.25), Prefer="wait=40")
        expect(after[0] == 200, after[2][:300])
        expect(daemon.get_json(f"/v1/drapes/{job}") == state, "an ended job has changed")
        daemon.end_well()
    finally:
        daemon.remove()


def test_term_under_load():
    random = seed()
    daemon = Daemon("--workers", "2").start()
    ledger = None
    try:
        port = daemon.port
        ledger = Ledger(daemon, CLIENTS, random)
        daemon.submit(saddle(0.004))
        for _ in range(10 if LONG else 3):
            time.sleep(0.3 + 0.5 * random.random())
            status, seconds = daemon.stop()
            expect(status == 0, f"exit status {status} at SIGTERM")
            print(f"# ended {seconds:.1f} s after SIGTERM")
            daemon.start(port=port)
        ledger.stop()
        ledger.settle(SETTLE_SECONDS)
        print(f"# {ledger.summary()}")
        expect_sound_log(daemon)
    finally:
        if ledger:
            ledger.stop()
        daemon.remove()


def main():
    tap = Tap()
    tap.run(f"kills: {KILLS} at random lose no job and change no answer", test_kills)
    tap.run("kills: a poison job ends as solver-crashed after three attempts", test_poison_job_ends)
    tap.run("kills: a stopped worker costs its job's time and no more", test_stopped_worker)
    tap.run("kills: SIGTERM under load ends well within 30 s and loses no job",
            test_term_under_load)
    tap.finish()


if __name__ == "__main__":
    main()
