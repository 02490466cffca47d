import os

import pytest

from sooner.errors import DataFormatError
from sooner.io.reading import MOST_BYTES_OF_TOML, read_toml

EXPECTED = "expected a study in TOML"


def refusal(path):
    with pytest.raises(DataFormatError) as raised:
        read_toml(path, EXPECTED)
    (fault,) = raised.value.faults
    assert (fault.file, fault.key) == (str(path), "")
    return fault


@pytest.mark.parametrize(
    ("content", "came"),
    [
        (b"title = ", "it is not TOML"),
        (b"\xff\xfe\x00", "something that is not text came"),
        (b"a = " + b"[" * 20_000, "it is not TOML"),
        (b"a = " + b"9" * 5_000, "it is not TOML"),
        (b"#" * (MOST_BYTES_OF_TOML + 1), "a file of more than 10 MB came"),
    ],
    ids=["broken", "binary", "deep", "a number of thousands of digits", "huge"],
)
def test_what_is_not_toml_is_refused_with_what_was_expected(tmp_path, content, came):
    (tmp_path / "s.toml").write_bytes(content)
    fault = refusal(tmp_path / "s.toml")
    assert came in fault.came
    assert fault.expected == EXPECTED


def test_a_byte_order_mark_is_no_fault(tmp_path):
    (tmp_path / "s.toml").write_bytes(b"\xef\xbb\xbfa = 1")
    assert read_toml(tmp_path / "s.toml", EXPECTED) == {"a": 1}


def test_what_is_no_file_is_told_once_and_by_its_kind(tmp_path):
    assert refusal(tmp_path).came == "a folder came"
    assert refusal(tmp_path / "none").came == "there is no such file"
    assert refusal(tmp_path / "a\0b").came.startswith("it cannot be read")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without named pipes")
def test_a_pipe_is_refused_before_anybody_waits_for_it(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert refusal(tmp_path / "pipe").came == "something that is not an ordinary file came"
