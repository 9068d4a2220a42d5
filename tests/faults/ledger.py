# SPDX-License-Identifier: MIT
"""Clients that submit and collect without end, and a ledger of what they were promised: no id that
was acknowledged may be lost, and nothing may be answered in two ways."""
import hashlib
import json
import threading
import time

from daemon import expect, saddle

CLIENT_PAUSE = 0.005  # seconds; the load is to be there, not to drown the machine
RESULT_PATH = "/v1/drapes/%s/result?fields=nodes.i,nodes.shear_deg,cells.shear_deg&format=csv"


class Ledger:
    def __init__(self, daemon, clients, random):
        self.daemon = daemon
        self.lock = threading.Lock()
        self.jobs = {}  # id -> key of its submission
        self.results = {}  # id -> digest of its result
        self.faults = []
        self.refused = 0  # calls that got no answer, or 503
        self.collected = 0
        self.run_id = random.getrandbits(32)
        self.going = True
        self.threads = [threading.Thread(target=self.work, args=(k,)) for k in range(clients)]
        for thread in self.threads:
            thread.start()

    def stop(self):
        self.going = False
        for thread in self.threads:
            thread.join()

    def work(self, client):
        number = 0
        while self.going:
            number += 1
            try:
                self.one(client, number)
            except OSError:
                with self.lock:
                    self.refused += 1
                time.sleep(0.02)
            except Exception as error:
                with self.lock:
                    self.faults.append(f"{type(error).__name__}: {error}")
                return
            time.sleep(CLIENT_PAUSE)

    def one(self, client, number):
        # A few dozen different drapes: equal ones share results, and some are new to the store.
        request = saddle(0.2 + 0.001 * (number % 40) + 0.0001 * client)
        key = f"{self.run_id}-{client}-{number}"
        job = self.submit(request, key)
        if job and number % 3 == 0:
            again = self.submit(request, key)
            expect(again in (None, job), f"key {key} is job {job}, then {again}")
        if job and number % 2 == 0:
            self.look(job)

    def submit(self, request, key):
        """The id; tried again with the same key until there is an answer, as a caller would."""
        while self.going:
            try:
                status, _, body = self.daemon.submit(request, Idempotency_Key=key)
            except OSError:
                with self.lock:
                    self.refused += 1
                time.sleep(0.02)
                continue
            if status == 503:
                continue
            expect(status == 202, f"submit is {status}: {body[:200]}")
            job = json.loads(body)["id"]
            with self.lock:
                expect(self.jobs.setdefault(job, key) == key, f"{job} for two keys")
            return job
        return None

    def look(self, job):
        """One look at a job that was acknowledged; its result, when it is there."""
        status, _, body = self.daemon.call("GET", f"/v1/drapes/{job}")
        if status == 503:
            return None
        expect(status == 200, f"job {job} is {status}: {body[:200]}")
        state = json.loads(body)["status"]
        expect(state in ("queued", "running", "succeeded"), f"job {job}: {body[:400]}")
        if state == "succeeded":
            self.collect(job)
        elif job in self.results:
            raise AssertionError(f"job {job} had succeeded and is {state} now")
        return state

    def collect(self, job):
        status, headers, body = self.daemon.call("GET", RESULT_PATH % job)
        if status == 503:
            return
        expect(status == 200, f"the result of {job} is {status}: {body[:200]}")
        found = (headers["etag"], hashlib.sha256(body).hexdigest())
        with self.lock:
            self.collected += 1
            before = self.results.setdefault(job, found)
        expect(found == before, f"job {job} has another result than before")

    def settle(self, seconds):
        """Every job ends, and every result is what it was. The load is over by then."""
        end = time.monotonic() + seconds
        waiting = set(self.jobs)
        while waiting:
            expect(time.monotonic() < end, f"{len(waiting)} jobs do not end: {sorted(waiting)[:3]}")
            waiting = {job for job in waiting if self.look(job) != "succeeded"}
            time.sleep(0.05)
        expect(len(self.results) == len(self.jobs), "a job without a result")
        expect(not self.faults, self.faults[:3])

    def summary(self):
        return (f"{len(self.jobs)} ids acknowledged, {self.collected} results read, "
                f"{self.refused} calls without an answer")
