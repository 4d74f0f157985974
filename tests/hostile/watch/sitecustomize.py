"""Imported by every Python process of a watched command: writes down what is opened for writing, and bars sockets.

Python's own acts are seen by an audit hook. On Linux the kernel ends any process that asks for a socket, in whatever
language it asks.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys

LOG = os.environ.get("WATCH_LOG")
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
CHANGING = ("mkdir", "rename", "remove", "rmdir", "link", "symlink", "truncate", "chmod", "chown", "utime", "mkfifo")
SYSTEM_CALL = {"x86_64": 41, "aarch64": 198}  # the number of socket()


class Instruction(ctypes.Structure):
    """Of a filter of system calls [Linux, include/uapi/linux/filter.h]."""

    _fields_ = [("code", ctypes.c_ushort), ("yes", ctypes.c_ubyte), ("no", ctypes.c_ubyte), ("value", ctypes.c_uint32)]


class Program(ctypes.Structure):
    """A filter of system calls."""

    _fields_ = [("length", ctypes.c_ushort), ("instructions", ctypes.POINTER(Instruction))]


def bar_sockets() -> bool:
    """Have the kernel end this process, and all that it starts, at a call of socket(); False where it cannot."""
    number = SYSTEM_CALL.get(os.uname().machine) if sys.platform == "linux" else None
    if number is None:
        return False
    load_number, equal, kill, allow = 0x20, 0x15, (0x06, 0, 0, 0x80000000), (0x06, 0, 0, 0x7FFF0000)
    steps = (load_number, 0, 0, 0), (equal, 0, 1, number), kill, allow
    program = Program(len(steps), (Instruction * len(steps))(*(Instruction(*step) for step in steps)))
    control = ctypes.CDLL(None).prctl
    no_new_privileges, set_filter = (38, 1, 0, 0, 0), (22, 2)
    return control(*no_new_privileges) == 0 and control(*set_filter, ctypes.byref(program)) == 0


def _where(path: str | bytes | os.PathLike[str], folder: object) -> str:
    """A path that may be relative to an open folder."""
    relative = isinstance(folder, int) and folder > 2 and not os.path.isabs(path)
    return os.path.join(os.readlink(f"/proc/self/fd/{folder}") if relative else "", os.fsdecode(path))


def _note(log: int) -> None:
    def hook(event: str, arguments: tuple[object, ...]) -> None:
        if event == "open":
            path, _, flags = arguments
            if not isinstance(flags, int) or not flags & WRITING or isinstance(path, int):
                return
            told = [path]
        elif event.startswith("os.") and event[3:] in CHANGING:
            folder = None if event == "os.truncate" else arguments[-1]
            told = [_where(path, folder) for path in arguments if isinstance(path, str | bytes | os.PathLike)]
        elif event.startswith("socket.") or event in ("os.exec", "os.system", "os.posix_spawn", "os.fork"):
            told = [repr(arguments)]
        elif event == "subprocess.Popen":
            told = [" ".join(map(str, arguments[1])) if isinstance(arguments[1], list | tuple) else str(arguments[1])]
        else:
            return
        where = [os.path.abspath(os.fsdecode(path)) if event[:3] in ("ope", "os.") else path for path in told]
        os.write(log, (json.dumps([event, *where]) + "\n").encode())

    sys.addaudithook(hook)


if LOG:
    if os.environ.get("WATCH_SOCKETS") == "barred":
        bar_sockets()
    _note(os.open(LOG, os.O_WRONLY | os.O_APPEND | os.O_CREAT))
