"""Whatever a mission file says, it is read or refused with its faults; nothing else comes out."""

import contextlib
import tempfile
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.errors import DataFormatError
from sooner.missions import read_mission

NUMBERS = st.one_of(st.integers(-3, 8), st.sampled_from([10**6, 10**30, -(2**63)]), st.floats())
CELLS = st.lists(NUMBERS, max_size=3)
FILES = st.sampled_from(
    ["poc.csv", "theta.csv", "rock.csv", "flat.csv", "none.csv", "", ".", "poc.tif", "../poc.csv", "\0.csv"]
)
ANYTHING = st.one_of(
    NUMBERS, CELLS, FILES, st.booleans(), st.dictionaries(st.sampled_from(["lat", "x", "pixels"]), NUMBERS)
)
WORDS = st.sampled_from(
    [
        "square4",
        "square8",
        "hex",
        "copter",
        "fixed_wing",
        "cells",
        "regions",
        "detection",
        "information",
        "beta",
        "aware",
    ]
)
MOVES = st.sampled_from(["cells", "regions"])
CAMERA = {"fov_deg": 90.0, "altitude_m": 4.0, "pixels": 100, "exposure_s": 0.001}


def table(**keys):
    return st.fixed_dictionaries({}, optional={key: st.one_of(value, ANYTHING, WORDS) for key, value in keys.items()})


MISSIONS = st.fixed_dictionaries(
    {
        "area": table(
            poc=st.just("poc.csv"),
            evidence=st.just("theta.csv"),
            outside=st.just(0.1),
            cell_m=st.just(2.0),
            obstacles=FILES,
            grid=WORDS,
        ),
        "sensor": table(
            difficulty=FILES,
            glimpse=st.just(0.5),
            correlation=st.just(0.1),
            detect=st.just(0.9),
            false_alarm=st.just(0.1),
            model=WORDS,
            radius_m=st.just(2.0),
            camera=st.just(CAMERA),
            range_m=st.just(5.0),
        ),
        "searcher": st.lists(
            table(
                start=st.just([0, 0]), end=CELLS, kind=WORDS, speed_mps=st.just(1.0), moves=MOVES, accel_mps2=st.just(1)
            ),
            max_size=2,
        ),
        "budget": table(steps=st.integers(0, 9), seconds=st.just(9.0)),
    },
    optional={
        "objective": table(kind=WORDS, detection_target=st.just(0.5), early=st.booleans()),
        "links": table(range_m=st.just(4.0), loss=st.just(0.5), relays=st.booleans()),
        "regions": table(cut=WORDS, spacing_m=st.just(2.0), min_area_m2=st.just(0.0), turns=WORDS),
        "name": ANYTHING,
        "other": ANYTHING,
    },
)


def toml(value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + "".join(f"\\u{ord(c):04x}" for c in value) + '"'
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(each)}" for key, each in value.items()) + "}"
    return repr(value)


@settings(max_examples=300, deadline=None)
@given(MISSIONS)
def test_a_mission_is_read_or_refused(said):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "poc.csv").write_text("1,2,3\n4,5,6\n0,1,0\n")
        (folder / "theta.csv").write_text("0.5,0.5,0.2\n0.9,0.5,0.5\n0.5,0.1,0.5\n")
        (folder / "rock.csv").write_text("0,0,0\n0,1,0\n0,0,0\n")
        (folder / "flat.csv").write_text("0.5,0.5\n")
        (folder / "poc.tif").write_bytes(b"II*")
        (folder / "mission.toml").write_text("\n".join(f"{key} = {toml(value)}" for key, value in said.items()))
        with contextlib.suppress(DataFormatError):
            assert read_mission(folder / "mission.toml").problem.grid.shape == (3, 3)
