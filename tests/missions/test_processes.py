"""Many seeds in several processes: the same answers, and a quiet end that keeps what was made."""

import ast
import multiprocessing
import subprocess
import sys

import pytest

from sooner.missions.processes import for_each_seed

SCRIPT = """
import os, signal, sys, threading, time
from sooner.missions.processes import for_each_seed

def work(seed):
    if seed == 5:  # whoever has come so far ends it: for all, as a terminal does
        time.sleep(1.0)
        os.killpg(0, signal.SIGINT)
    if seed >= 5:
        time.sleep(600.0)
    return seed

if __name__ == "__main__":
    made = []
    if sys.argv[1] != "late":
        threading.Timer(float(sys.argv[1]), lambda: os.killpg(0, signal.SIGINT)).start()
    try:
        for seed in for_each_seed(work, range(100), 2):
            made.append(seed)
    except KeyboardInterrupt:
        print(made)
"""


def test_workers_change_neither_what_comes_nor_its_order():
    assert list(for_each_seed(abs, range(-100, 3), 2)) == list(for_each_seed(abs, range(-100, 3), 1))


@pytest.mark.skipif(sys.platform == "win32", reason="process groups")
@pytest.mark.parametrize("when", ["0.02", "0.2", "0.6", "late"])
def test_an_interruption_is_quiet_and_keeps_what_was_made(tmp_path, when):
    (tmp_path / "script.py").write_text(SCRIPT)
    command = [sys.executable, str(tmp_path / "script.py"), when]
    ended = subprocess.run(command, capture_output=True, text=True, start_new_session=True, timeout=120, check=False)
    assert ended.stderr == ""
    assert ended.returncode == 0
    made = ast.literal_eval(ended.stdout)
    assert made == list(range(len(made)))
    if when == "late":
        assert made == [0, 1, 2, 3, 4]


def test_nobody_is_left_where_one_has_seen_enough():
    before = set(multiprocessing.active_children())
    flights = for_each_seed(abs, range(100), 2)
    assert next(flights) == 0
    flights.close()
    assert set(multiprocessing.active_children()) <= before
