"""The picture of a study: whatever was flown, it is drawn, and says what it leaves out."""

import io

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from sooner.plotting import Sample, plot_summary
from sooner.plotting.summary_picture import DOTS_MOST


def samples(count, n=20, value=0.5):
    rng = np.random.default_rng(count)
    values = [value + rng.normal(size=n) / 10 for _ in range(count)]
    return [Sample(f"planner {k}", v, v.mean(), v.mean() - 0.02, v.mean() + 0.02) for k, v in enumerate(values)]


def drawn(title, measure, places, yes_no=False):
    picture = plot_summary(title, measure, places, yes_no)
    assert picture.startswith(b"\x89PNG")
    return imread(io.BytesIO(picture))


@pytest.fixture
def figures(monkeypatch):
    """Every figure that is saved."""
    saved, save = [], Figure.savefig
    monkeypatch.setattr(
        Figure, "savefig", lambda self, *more, **named: saved.append(self) or save(self, *more, **named)
    )
    return saved


@pytest.mark.parametrize(("planners", "places"), [(1, 1), (2, 1), (12, 8), (3, 5), (16, 12)])
def test_any_number_of_planners_and_places_is_drawn(planners, places, figures):
    drawn("Many", "value", {f"place {k}": samples(planners) for k in range(places)})
    (figure,) = figures
    assert len(figure.axes) == places
    assert all(len(axes.get_yticks()) == planners for axes in figure.axes)


def test_every_trial_is_a_dot_and_every_mean_has_its_interval(figures):
    given = samples(2)
    drawn("Two", "value", {"here": given})
    (axes,) = figures[0].axes
    assert [len(dots.get_offsets()) for dots in axes.collections] == [20, 20]
    intervals = [tuple(line.get_xdata()) for line in axes.lines if line.get_linewidth() == 2.6]
    assert intervals == [(sample.low, sample.high) for sample in given]


def test_of_very_many_trials_an_even_share_is_drawn(figures):
    drawn("Many", "value", {"here": samples(1, 100_000)})
    assert 0.9 * DOTS_MOST <= len(figures[0].axes[0].collections[0].get_offsets()) <= DOTS_MOST


def test_yes_and_no_are_told_as_percent(figures):
    values = np.array([0.0, 1.0, 1.0, 1.0])
    drawn("Who finds", "found", {"here": [Sample("a", values, 0.75, 0.3, 0.95)]}, yes_no=True)
    assert figures[0].axes[0].collections[0].get_offsets()[:, 0].tolist() == [0.0, 100.0, 100.0, 100.0]
    assert any(text.get_text().startswith("found, %: ") for text in figures[0].texts)


def test_what_does_not_fit_is_left_out_and_said_so(figures):
    drawn("Too many", "value", {f"place {k}": samples(20) for k in range(13)})
    assert len(figures[0].axes) == 12
    assert any("the first 12 of 13 places; the first 16 of 20 planners" in text.get_text() for text in figures[0].texts)


def test_planners_that_differ_from_place_to_place_are_named_in_each(figures):
    drawn("Uneven", "value", {"one": samples(2), "two": samples(3)})
    names = [[label.get_text() for label in axes.get_yticklabels()] for axes in figures[0].axes]
    assert [len(list(filter(None, some))) for some in names] == [2, 3]


def test_names_of_any_length_and_script_and_equal_values_are_drawn():
    flat = Sample("x" * 200, np.full(3, 2.0), 2.0, 2.0, 2.0)
    picture = drawn("$title$ " * 40, "value", {"山 " * 60: [flat]})
    assert picture.shape[1] < 2500


def test_the_same_trials_give_the_same_picture():
    places = {"here": samples(3)}
    assert plot_summary("Same", "value", places) == plot_summary("Same", "value", places)


def test_a_planner_without_a_number_has_its_line_and_says_why(figures):
    failed = Sample("broken", note="all 20 trials failed")
    drawn("Some", "value", {"here": [failed, *samples(1)], "there": [failed]})
    for axes in figures[0].axes:
        assert [text.get_text() for text in axes.texts] == ["all 20 trials failed"]
    here, there = figures[0].axes
    assert [label.get_text() for label in here.get_yticklabels()] == ["broken", "planner 0"]
    assert (len(here.collections), len(there.collections)) == (1, 0)


def test_a_note_stands_below_the_title(figures):
    drawn("Typo", "value", {"here": samples(1)})
    assert len(figures[0].texts) == 2
    plot_summary("Typo", "value", {"here": samples(1)}, False, "no trial has a number called 'valeu'")
    assert figures[1].texts[-1].get_text() == "no trial has a number called 'valeu'"
