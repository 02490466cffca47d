"""Watches a worker, and ends what its trials have started once it is gone, however it went.

    python guard.py WORKER

It stands in the process group of the worker and imports nothing of sooner's: a small process that sleeps.
"""

import ctypes
import os
import signal
import sys
import time

__all__ = ["main"]


def main() -> None:
    """Wait until the worker is gone, then end its group, this process as well."""
    worker = int(sys.argv[1])
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # what the kernel sends us when the worker ends
        if os.getppid() == worker:
            signal.sigwait({signal.SIGTERM})
    while os.getppid() == worker and sys.platform != "linux":
        time.sleep(0.5)
    os.killpg(worker, signal.SIGKILL)


if __name__ == "__main__":
    main()
