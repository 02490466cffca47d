"""Public names: every `__all__` is sorted and true, and every room says what it exports."""

import pkgutil
from importlib import import_module

import pytest

import sooner

MODULES = sorted(module.name for module in pkgutil.walk_packages(sooner.__path__, "sooner."))


@pytest.mark.parametrize("name", ["sooner", *MODULES])
def test_what_a_module_promises_it_has(name):
    module = import_module(name)
    if not hasattr(module, "__all__"):
        assert name.rpartition(".")[2].startswith("_") or name == "sooner.cli", f"{name} says nothing of its names"
        return
    assert len(set(module.__all__)) == len(module.__all__)
    for exported in module.__all__:
        assert hasattr(module, exported), f"{name} promises {exported}"


def test_the_top_level_exports_about_a_dozen_names():
    assert 10 <= len(sooner.__all__) <= 20
    assert set(sooner.__all__) <= set(dir(sooner))


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="nothing_of_that_name"):
        _ = sooner.nothing_of_that_name
