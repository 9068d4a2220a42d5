# SPDX-License-Identifier: MIT
"""What other callers see while all hostile ones of `hostile.py` are at work at once: the time of
/healthz and of small drapes, and the memory of the daemon with its checkers. Prints each figure
with its bound; exits 1 when one is missed and STRICT is set.

Usage: gate.py [FLAG...]: of the daemon; with --role api the workers are another one of the same
flags. GATE_SECONDS is how long (30). The daemon is BUILD/draped (build).
"""
import os
import sys
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "faults"))
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from daemon import Daemon  # noqa: E402
from hostile import Hostile, saddle  # noqa: E402

SECONDS = float(os.environ.get("GATE_SECONDS", "30"))
HEALTH_MS, DRAPE_MS, MEMORY_MIB = 100, 1000, 1024
SETTLE = 3  # until all hostile ones are at work


def proportional_memory(pid):
    with open(f"/proc/{pid}/smaps_rollup") as file:
        return sum(int(line.split()[1]) for line in file if line.startswith("Pss:"))


def memory(daemon):
    """KiB of the daemon and its checkers, what they share counted once."""
    total = proportional_memory(daemon.process.pid)
    for pid in daemon.children():
        try:
            with open(f"/proc/{pid}/cmdline", "rb") as line:
                if line.read().split(b"\0")[1] in (b"checker", b"fork-server"):
                    total += proportional_memory(pid)
        except (OSError, IndexError):
            continue  # it has ended
    return total


class Victim:
    """Calls at a steady rate and notes how long each took; one that fails took for ever."""

    def __init__(self, call, pause, until):
        self.times, self.failures = [], []
        self.thread = threading.Thread(target=self.go, args=(call, pause, until))
        self.thread.start()

    def go(self, call, pause, until):
        number = 0
        while time.monotonic() < until:
            begun = time.monotonic()
            try:
                status = call(number)
            except OSError as error:
                status = str(error)
            took = time.monotonic() - begun
            self.times.append(took if status == 200 else float("inf"))
            if status != 200:
                self.failures.append(status)
            number += 1
            time.sleep(max(0.0, pause - took))

    def quantile(self, share):
        ordered = sorted(self.times)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))] * 1000


def health(daemon):
    return lambda number: daemon.call("GET", "/healthz", timeout=20)[0]


def small_drape(daemon, begin=0):
    def call(number):
        request = saddle(0.2 + 1e-6 * (begin + number))
        status, _, body = daemon.submit(request, Prefer="wait=20")
        return status if status == 200 else f"{status} {body[:300]}"
    return call


def say(name, figure, unit, bound, note=""):
    met = figure <= bound
    print(f"{name:<28} {figure:10.1f} {unit:<12} target <= {bound:<7} "
          f"{'met' if met else 'missed'} {note}", flush=True)
    return met


def report(health_calls, drapes, peak, answers):
    met = True
    for name, victim, bound in (("gate: healthz p99", health_calls, HEALTH_MS),
                                ("gate: small drapes p99", drapes, DRAPE_MS)):
        note = f"median {victim.quantile(0.5):.1f} ms of {len(victim.times)}"
        if victim.failures:
            note += f", {len(victim.failures)} failed: {sorted(set(map(str, victim.failures)))[:4]}"
        met &= say(name, victim.quantile(0.99), "ms", bound, note)
    met &= say("gate: memory", peak / 1024, "MiB", MEMORY_MIB, "daemon and checkers, at most")
    for name, statuses in sorted(answers.items()):
        print(f"#   {name}: {statuses}")
    return met


def attack(daemon):
    done = daemon.submit(saddle(0.2), Prefer="wait=20")
    drape = done[1]["location"].rsplit("/", 1)[1]
    hostile = Hostile(daemon.port, SECONDS + SETTLE, 1, drape)
    time.sleep(SETTLE)
    until = time.monotonic() + SECONDS
    victims = [Victim(health(daemon), 0.05, until), Victim(small_drape(daemon, 1), 0.2, until)]
    peak = 0
    while time.monotonic() < until:
        peak = max(peak, memory(daemon))
        time.sleep(0.25)
    for victim in victims:
        victim.thread.join()
    return report(*victims, peak, hostile.collect())


def main():
    flags = sys.argv[1:]
    daemons = [Daemon(*flags).start()]
    try:
        if "api" in flags:
            other = ["worker" if flag == "api" else flag for flag in flags]
            daemons.append(Daemon(*other).start())
        met = attack(daemons[0])
    finally:
        for daemon in daemons:
            daemon.remove()
    return 0 if met or not os.environ.get("STRICT") else 1


if __name__ == "__main__":
    sys.exit(main())
