"""Trials for the tests of campaigns: a number that follows from the seed; or, where the planner says so, a mishap."""

import os
import signal
import sys
import time
from pathlib import Path


def fly(trial, place):
    MISHAPS[trial.planner.get("mishap", "none")](trial, Path(place.folder))
    time.sleep(float(os.environ.get("NAP_S", "0")))
    number = trial.seed
    for _ in range(1000):
        number = (number * 6364136223846793005 + 1442695040888963407) % 2**64
    return {"value": number / 2**64, "odd": number % 2 == 1, "said": "x" * trial.planner.get("words", 0)}


def times(folder, trial, most):
    """Whether this trial was here fewer than `most` times before."""
    with (folder / f"{trial.case.planner}-{trial.seed}").open("a+") as been:
        been.write("x")
        return been.tell() <= most


def raises(trial, folder):
    raise ValueError("the map has no snow")


def raises_once(trial, folder):
    if times(folder, trial, 1):
        raises(trial, folder)


def dies(number, most=1000):
    return lambda trial, folder: times(folder, trial, most) and os.kill(os.getpid(), number)


def exits(trial, folder):
    print("what it said last")
    sys.exit(3)


def hangs(trial, folder):
    while True:
        time.sleep(1)


def eats(trial, folder):
    eaten = []
    while True:
        eaten.append(bytearray(b"x") * 40_000_000)
        time.sleep(0.01)


def leaves_a_child(trial, folder):
    if os.fork() == 0:
        time.sleep(20)  # holds every pipe that its parent had
    os._exit(4)


def interrupts_itself(trial, folder):
    os.kill(os.getpid(), signal.SIGINT)


MISHAPS = {
    "none": lambda trial, folder: None,
    "raises": raises,
    "raises once": raises_once,
    "segfault": dies(signal.SIGSEGV),
    "abort": lambda trial, folder: os.abort(),
    "killed": dies(signal.SIGKILL),
    "killed 4 times": dies(signal.SIGKILL, 4),
    "exits": exits,
    "hangs": hangs,
    "eats": eats,
    "leaves a child": leaves_a_child,
    "interrupts itself": interrupts_itself,
}
