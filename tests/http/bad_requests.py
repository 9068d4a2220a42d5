# SPDX-License-Identifier: MIT
"""Posts every request of tests/unit/bad_requests and looks whether it is refused as its .expect
says: the problem's name, and below it the pointers of what is wrong. Prints how many there were.
Usage: bad_requests.py PORT"""
import http.client
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "faults"))
from daemon import expect, expect_problem  # noqa: E402


def post(connection, body):
    """Status, headers in small letters, body."""
    connection.request("POST", "/v1/drapes", body, {"Content-Type": "application/json"})
    answer = connection.getresponse()
    return answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read()


def check(port, file):
    """Whether it was one for this daemon: those about other limits than its own are not."""
    slug, *pointers = file.with_suffix(".expect").read_text().splitlines()
    if slug == "too-large":
        return False
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=50)
    status, headers, body = post(connection, file.read_bytes())
    connection.close()
    expect_problem(status, headers, body, slug)
    if slug == "invalid-request":
        said = {error["pointer"] for error in json.loads(body)["errors"]}
        missing = {"" if pointer == "#" else pointer for pointer in pointers} - said
        expect(status == 422 and not missing, f"status {status}, not said: {missing}: {body}")
    return True


def main(port):
    count = 0
    for file in sorted(Path("tests/unit/bad_requests").glob("*.json")):
        try:
            count += check(port, file)
        except Exception as error:
            raise SystemExit(f"{file}: {error}") from error
    print(count)


main(int(sys.argv[1]))
