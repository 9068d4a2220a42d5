# SPDX-License-Identifier: MIT
# For the tests of deploy/: what those of the daemon have (tests/http/helper.bash), and this.
load ../http/helper

free_port() {
    python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}
