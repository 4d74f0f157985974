"""No test reads or leaves anything in the cache folder of the user; one that is about it has a folder of its own.

Nor does a test depend on how it was started: in the background of a shell, or under nohup, signals are ignored, and a
command honours that.
"""

import os
import signal

os.environ["SHORTFINAL_CACHE"] = "off"

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
