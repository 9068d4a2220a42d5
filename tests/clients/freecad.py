# SPDX-License-Identifier: MIT
"""The FreeCAD workbench in FreeCAD, without a display and in a window that nobody sees. `make freecad` runs it.
With --pictures it writes those of clients/freecad/README.md."""
import os
import subprocess
import sys
import tempfile

sys.path.append(os.path.join(os.path.dirname(__file__), "..", "faults"))
from daemon import BUILD, Daemon  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
WINDOW = ["xvfb-run", "-a", "-s", "-screen 0 1280x900x24", "freecad"]


def run(command, script, url, folder):
    """What the script finds: its own lines; whether all is right and none is missing."""
    tap = os.path.join(folder, "tap")
    env = {**os.environ, "HOME": folder, "URL": url, "TAP": tap, "FOLDER": folder, "DRAPE": os.path.abspath(f"{BUILD}/drape"),
           "QTWEBENGINE_DISABLE_SANDBOX": "1", "QTWEBENGINE_CHROMIUM_FLAGS": "--no-sandbox"}
    if "--pictures" in sys.argv:
        env["PICTURES"] = os.path.abspath("docs/figures")
    done = subprocess.run([*command, os.path.join(HERE, script)], env=env, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=600)
    if not os.path.exists(tap):
        print(f"not ok - {script} does not begin:\n{done.stdout[-3000:]}")
        return False
    with open(tap, encoding="utf-8") as file:
        lines = file.read()
    os.remove(tap)
    print(lines, end="")
    whole = any(line.startswith("1..") for line in lines.splitlines())
    if not whole:
        print(f"not ok - {script} ends early:\n{done.stdout[-3000:]}")
    return whole and "not ok" not in lines


def main():
    daemon = Daemon().start()
    try:
        with tempfile.TemporaryDirectory() as folder:
            url = f"http://127.0.0.1:{daemon.port}"
            good = [run(["freecadcmd"], "freecad_drapes.py", url, folder),
                    run(WINDOW, "freecad_panel.py", url, folder)]
    finally:
        daemon.stop()
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
