# SPDX-License-Identifier: MIT
"""All hostile callers of tests/load/hostile.py at a fraction of their size: what others ask for is
answered, and what they do is answered as it should be. How fast is for `make load`."""
import json
import os
import resource
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "load")]
from daemon import LONG, Daemon, Tap, expect, expect_sound_log, saddle  # noqa: E402
from hostile import Hostile  # noqa: E402

SECONDS = 20 if LONG else 6
DRAPE_SECONDS = 120  # until a small drape has ended
# Made or refused; "none" and "closed" are connections that made room for others.
RIGHT = {"200", "201", "202", "408", "413", "422", "429", "503", "none", "closed"}


def drape(daemon, number):
    """Its end, which on a busy machine may come after what one call waits for."""
    status, _, body = daemon.submit(saddle(0.2 + 1e-6 * number), Prefer="wait=10")
    end = time.monotonic() + DRAPE_SECONDS
    while status == 202 and time.monotonic() < end:
        place = f"/v1/drapes/{json.loads(body)['id']}"
        _, _, state = daemon.call("GET", f"{place}?wait=10")
        if json.loads(state).get("finished"):
            status, _, body = daemon.call("GET", f"{place}/result")
    return status, body


def calls_of_others(daemon, until):
    number = 0
    while time.monotonic() < until or number < 3:
        status = daemon.call("GET", "/healthz")[0]
        expect(status == 200, f"/healthz is {status}")
        status, body = drape(daemon, number)
        expect(status == 200, f"a small drape is {status}: {body[:200]}")
        number += 1
    return number


def test_hostile_callers_stand_in_nobodys_way():
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    daemon = Daemon("--workers", "2", "--max-connections", "400").start()
    try:
        location = daemon.submit(saddle(0.3), Prefer="wait=25")[1]["location"]
        hostile = Hostile(daemon.port, SECONDS, 0.1, location.rsplit("/", 1)[1])
        number = calls_of_others(daemon, time.monotonic() + SECONDS)
        answers = hostile.collect()
        print(f"# {number} small drapes of others; {answers}")
        for name, statuses in answers.items():
            expect({status.split()[0] for status in statuses} <= RIGHT, f"{name}: {statuses}")
        expect(daemon.call("GET", "/readyz")[0] == 200, "it is not ready afterwards")
        expect_sound_log(daemon)
        daemon.end_well()
    finally:
        daemon.remove()


tap = Tap()
tap.run("test_hostile_callers_stand_in_nobodys_way", test_hostile_callers_stand_in_nobodys_way)
tap.finish()
