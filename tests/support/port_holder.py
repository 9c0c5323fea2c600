"""Other programs that have a port open: real processes, under the name of a known one."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["hold"]

_HOLDER = """
import ctypes, fcntl, os, select, sys, termios, threading, time
name, path, how, reads, seconds = sys.argv[1:]
# PR_SET_NAME: what /proc/PID/comm and ps say.
ctypes.CDLL(None).prctl(15, name.encode(), 0, 0, 0)
port = os.open(path, os.O_RDWR | os.O_NOCTTY | (os.O_NONBLOCK if reads != "blocking" else 0))
if how == "exclusive":
    fcntl.ioctl(port, termios.TIOCEXCL)
elif how == "locked":
    fcntl.flock(port, fcntl.LOCK_EX)
if reads == "vmin0":
    settings = termios.tcgetattr(port)
    settings[6][termios.VMIN] = 0
    termios.tcsetattr(port, termios.TCSANOW, settings)

def let_go():
    if how == "exclusive":
        fcntl.ioctl(port, termios.TIOCNXCL)
    print("gone", flush=True)
    os._exit(0)

def wait():
    if float(seconds):
        time.sleep(float(seconds))
    else:
        sys.stdin.readline()
    let_go()

threading.Thread(target=wait).start()
print("has it", flush=True)
while reads != "nothing":
    if reads != "blocking":
        select.select([port], [], [])
    try:
        os.read(port, 4096)
    except OSError:
        time.sleep(0.001)
"""


@contextmanager
def hold(
    path: str, name: str, *, how: str = "open", reads: str = "nothing", seconds: float = 0.0
) -> Iterator["subprocess.Popen[bytes]"]:
    """Within it, a process has the port open, and lets go at the end, or by itself.

    Args:
        path: The port.
        name: What the process is called.
        how: `open`, `exclusive` (TIOCEXCL, as ModemManager) or `locked` (flock, as minicom).
        reads: `nothing`, `blocking` as `cat`, `fair`, which waits with `select`, or `vmin0`,
            which has changed the settings as pyserial does, and waits with `select`.
        seconds: After how long it lets go by itself; 0: when the block ends.
    """
    command = [sys.executable, "-c", _HOLDER, name, path, how, reads, str(seconds)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"has it\n"
        try:
            yield process
        finally:
            try:
                process.communicate(b"\n", timeout=10)
            finally:
                process.kill()
