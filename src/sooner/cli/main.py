"""The console script. It imports nothing of weight before it can answer Ctrl-C."""

from __future__ import annotations

import signal
import sys

__all__ = ["main", "run"]


def main() -> None:
    """Run what the command line asks for, and end with its status."""
    status = run(sys.argv[1:])
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done and said: it is too late to interrupt
    sys.exit(status)


def run(arguments: list[str]) -> int:
    """Run a command line; answers the exit status."""
    try:
        from sooner.cli.app import run as asked

        return asked(arguments)
    except KeyboardInterrupt:
        return 130
