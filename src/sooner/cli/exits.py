"""How the terminal face ends: 0 done, 2 bad input, 1 our fault, 130 interrupted."""

from __future__ import annotations

import errno
import os
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from sooner import __version__
from sooner.errors import DataFormatError, SoonerError

__all__ = ["BAD_INPUT", "DONE", "INTERRUPTED", "OUR_FAULT", "ending", "say", "uninterrupted"]

NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
DONE, OUR_FAULT, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


def say(line: str) -> None:
    """One line to stderr."""
    print(line, file=sys.stderr, flush=True)


def ending(work: Callable[[], int]) -> int:
    """Do the work and answer with the exit status; nothing that goes wrong shows a traceback."""
    with _terminated_as_interrupted():
        try:
            status = work()
            sys.stdout.flush()  # a full disk shows itself here, while somebody can still be told
            return status
        except DataFormatError as error:
            for fault in error.faults:
                say(f"sooner: {fault}")
            return BAD_INPUT
        except SoonerError as error:
            say(f"sooner: {error}")
            return BAD_INPUT
        except KeyboardInterrupt as error:
            say(f"sooner: {error}" if error.args else "sooner: interrupted; nothing was written")
            return INTERRUPTED
        except BrokenPipeError:  # whoever read our output has had enough
            _drop_output()
            return DONE
        except OSError as error:
            if error.errno not in NO_ROOM:
                return _our_fault(error)
            _drop_output()
            say(f"sooner: the output cannot be written: {error.strerror}; expected room for it")
            return BAD_INPUT
        except Exception as error:
            return _our_fault(error)


def _drop_output() -> None:
    """What is left in the buffer goes nowhere, so that ending does not fail on it once more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _our_fault(error: Exception) -> int:
    where = traceback.extract_tb(error.__traceback__)[-1]
    if os.environ.get("SOONER_TRACEBACK"):
        traceback.print_exception(error)
    say(f"sooner: this is a fault of sooner, not yours: {type(error).__name__}: {error}")
    say(f"sooner: in {where.name}, line {where.lineno} of {os.path.basename(where.filename)}; version {__version__}")  # noqa: PTH119
    say("sooner: please report it with your mission file; SOONER_TRACEBACK=1 shows where it happened")
    return OUR_FAULT


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """A polite request to end (SIGTERM) is treated as Ctrl-C, so that the best plan is kept."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    with _handling(signal.SIGTERM, interrupt):
        yield


@contextmanager
def uninterrupted() -> Iterator[None]:
    """While the best plan is written, a second Ctrl-C waits."""
    with _handling(signal.SIGINT, signal.SIG_IGN), _handling(signal.SIGTERM, signal.SIG_IGN):
        yield


@contextmanager
def _handling(number: signal.Signals, handler: Any) -> Iterator[None]:
    try:
        before = signal.signal(number, handler)
    except ValueError:  # not the main thread: signals are somebody else's
        yield
        return
    try:
        yield
    finally:
        signal.signal(number, before)
