"""The campaign before a crew that answers as it likes: every trial ends once, and in the order that is promised."""

import json
import random
import tempfile
from collections import Counter
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sooner.campaigns import Case, Outcome, Place, Trial
from sooner.campaigns.campaign import Asked, fly
from sooner.campaigns.ledger import Ledger
from sooner.campaigns.provenance import provenance
from sooner.errors import DataFormatError

PLACE = Place("work:fly")
MADE_BY = json.dumps(provenance(PLACE))


def case(planner: str, alone: bool = False) -> Case:
    return Case("here", planner, None, json.dumps({"instance": {}, "planner": {}}), alone)


def answer(trial: Trial) -> str:
    return json.dumps({"value": trial.seed * 7 % 5, "planner": trial.case.planner})


class PowerCutError(BaseException):
    """The machine went dark."""


class Mortal(Ledger):
    """A ledger that nobody writes any more once the power is gone."""

    dark = False

    def write(self, ended, leased):
        if not self.dark:
            super().write(ended, leased)

    def release(self, trials):
        if not self.dark:
            super().release(trials)


class Crew:
    """Answers each trial, the oldest first."""

    workers = 2

    def __init__(self, room: int = 4, made_by: str = MADE_BY) -> None:
        self.room, self.made_by = room, made_by
        self.flying: list[Trial] = []
        self.begun: list[Trial] = []
        self.company: list[frozenset[Trial]] = []
        self.closed = False

    def start(self, trial: Trial) -> None:
        self.flying.append(trial)
        self.begun.append(trial)
        self.company.append(frozenset(self.flying))

    def ended(self, wait_s: float) -> list[Outcome]:
        return [self.outcome(self.flying.pop(0))] if self.flying else []

    def outcome(self, trial: Trial, ending: str = "done") -> Outcome:
        said = answer(trial) if ending == "done" else ""
        return Outcome(trial, ending, said, "" if said else "bad luck", 0.1, 0.1, 50.0, self.made_by)

    def close(self) -> None:
        self.closed = True


class Fickle(Crew):
    """Answers in any order, twice, late or not at all; fails, loses and kills; and sometimes the power goes."""

    def __init__(self, rng: random.Random, ledger: Mortal) -> None:
        super().__init__(room=rng.randint(1, 5))
        self.rng, self.ledger = rng, ledger
        self.old: list[Outcome] = []

    def ended(self, wait_s: float) -> list[Outcome]:
        if self.rng.random() < 0.03:
            self.ledger.dark = self.rng.random() < 0.5
            raise PowerCutError
        self.rng.shuffle(self.flying)
        found = [self.outcome(self.flying.pop(), self._ending()) for _ in range(self.rng.randint(0, len(self.flying)))]
        again = [outcome for outcome in self.old if outcome.ending == "done" and self.rng.random() < 0.2]
        self.old += found
        return self.rng.sample(found + again, len(found + again))

    def _ending(self) -> str:
        return self.rng.choices(["done", "lost", "killed", "error", "crash"], [12, 2, 1, 1, 1])[0]


def asked_for(*cases: Case, seeds: int = 6) -> Asked:
    return Asked(tuple((each, range(seeds)) for each in cases))


@given(number=st.integers(0, 10**9))
@settings(max_examples=40)
def test_every_trial_ends_once_whatever_its_crew_does(number):
    rng = random.Random(number)
    asked = asked_for(case("a"), case("b"), case("a", alone=True), seeds=5)
    before, progress = 0, None
    with tempfile.TemporaryDirectory() as folder:
        while progress is None:
            with Mortal(Path(folder) / "trials.sqlite", "Small") as ledger:
                with suppress(PowerCutError, DataFormatError):  # the latter where nothing but failures came
                    progress = fly(asked, ledger, Fickle(rng, ledger), PLACE)
                done = sum(ledger.counts(each, seeds).done for each, seeds in asked.cases)
                assert done >= before
                before = done
        with Ledger(Path(folder) / "trials.sqlite", "Small") as ledger:
            rows = [(each, row) for each, seeds in asked.cases for row in ledger.rows(each, seeds)]
    assert Counter((each, row["seed"]) for each, row in rows) == Counter(
        (each, seed) for each, seeds in asked.cases for seed in seeds
    )
    for each, row in rows:
        told = {"done": json.loads(answer(Trial(each, row["seed"]))), "aside": {}}
        assert row["answer"] == told[row["state"]]
        assert row["reason"] if row["state"] == "aside" else row["attempts"] >= 1
    assert (progress.total, progress.done + progress.aside) == (15, 15)
    assert progress.done == before


@pytest.fixture
def ledger(tmp_path):
    with Ledger(tmp_path / "trials.sqlite", "Small") as opened:
        yield opened


def test_trials_go_by_seeds_and_then_by_cases(ledger):
    crew = Crew()
    fly(Asked(((case("b"), range(3)), (case("a"), range(2)), (case("c"), range(3)))), ledger, crew, PLACE)
    order = [(trial.seed, trial.case.planner) for trial in crew.begun]
    assert order == [(0, "b"), (0, "a"), (0, "c"), (1, "b"), (1, "a"), (1, "c"), (2, "b"), (2, "c")]
    assert crew.closed


def test_no_more_trials_are_in_the_air_than_there_are_places(ledger):
    crew = Crew(room=3)
    fly(asked_for(case("a"), case("b")), ledger, crew, PLACE)
    assert max(map(len, crew.company)) == 3


def test_what_is_done_is_not_flown_again_and_more_seeds_are_flown_as_well(ledger):
    fly(asked_for(case("a"), seeds=4), ledger, Crew(), PLACE)
    crew = Crew()
    assert fly(asked_for(case("a"), case("b"), seeds=6), ledger, crew, PLACE).done == 12
    assert [(trial.seed, trial.case.planner) for trial in crew.begun] == [
        (0, "b"), (1, "b"), (2, "b"), (3, "b"), (4, "a"), (4, "b"), (5, "a"), (5, "b")
    ]  # fmt: skip
    assert fly(asked_for(case("a"), seeds=3), ledger, Crew(), PLACE).done == 3


def test_trials_that_were_in_the_air_at_a_sudden_end_come_last(ledger):
    ledger.write([], [Trial(case("a"), 1), Trial(case("b"), 0)])
    ledger.recover()
    ledger.write([], [Trial(case("a"), 1)])
    crew = Crew()
    fly(asked_for(case("a"), case("b"), seeds=2), ledger, crew, PLACE)
    order = [(trial.case.planner, trial.seed) for trial in crew.begun]
    assert order == [("a", 0), ("b", 1), ("b", 0), ("a", 1)]


def test_trials_that_were_given_back_keep_their_turn(ledger):
    ledger.write([], [Trial(case("a"), 1)])
    ledger.release([Trial(case("a"), 1)])
    crew = Crew()
    fly(asked_for(case("a"), seeds=3), ledger, crew, PLACE)
    assert [trial.seed for trial in crew.begun] == [0, 1, 2]


def test_trials_that_fly_alone_fly_after_all_others_and_one_at_a_time(ledger):
    crew = Crew()
    fly(asked_for(case("a", alone=True), case("a"), case("b", alone=True), seeds=3), ledger, crew, PLACE)
    assert [trial.case.alone for trial in crew.begun] == [False] * 3 + [True] * 6
    assert all(len(flying) == 1 for trial, flying in zip(crew.begun, crew.company, strict=True) if trial.case.alone)


def test_second_attempts_come_after_all_others_but_before_those_that_fly_alone(ledger):
    class FailsOnce(Crew):
        def outcome(self, trial: Trial, ending: str = "done") -> Outcome:
            first = trial.seed == 0 and self.begun.count(trial) == 1
            return super().outcome(trial, "error" if first else ending)

    crew = FailsOnce(room=2)
    progress = fly(asked_for(case("a"), case("b", alone=True), seeds=3), ledger, crew, PLACE)
    order = [(trial.case.planner, trial.seed) for trial in crew.begun]
    assert order == [("a", 0), ("a", 1), ("a", 2), ("a", 0), ("b", 0), ("b", 1), ("b", 2), ("b", 0)]
    assert (progress.done, progress.aside) == (6, 0)
    assert "bad luck" in progress.last_failure


def test_a_trial_that_the_cluster_loses_is_never_to_blame(ledger):
    class Loses(Crew):
        def outcome(self, trial: Trial, ending: str = "done") -> Outcome:
            return super().outcome(trial, "lost" if self.begun.count(trial) < 30 else "done")

    assert fly(asked_for(case("a"), seeds=2), ledger, Loses(), PLACE).done == 2
    assert [row["attempts"] for row in ledger.rows(case("a"), range(2))] == [1, 1]


class Fails(Crew):
    """Every trial of planner b fails."""

    def outcome(self, trial: Trial, ending: str = "done") -> Outcome:
        return super().outcome(trial, "error" if trial.case.planner == "b" else ending)


def test_a_planner_whose_attempts_all_failed_is_left_out_and_the_others_go_on(ledger):
    crew = Fails(room=1)
    progress = fly(asked_for(case("b"), case("a"), case("b", alone=True), seeds=100), ledger, crew, PLACE)
    assert Counter(trial.case.planner for trial in crew.begun) == {"a": 100, "b": 20}
    assert (progress.done, progress.aside, progress.missing) == (100, 0, 200)
    (note,) = progress.notes
    assert note.startswith("b: all of its first 20 attempts failed, the rest is not flown; the last one: b on here")
    assert note.endswith("bad luck")
    assert [row["attempts"] for row in ledger.rows(case("b"), range(100))] == [1] * 20


def test_a_planner_is_not_given_up_before_each_of_its_cases_had_an_attempt(ledger):
    cases = [Case(f"place {number}", "b", None, "{}") for number in range(30)]
    crew = Fails(room=1)
    fly(asked_for(*cases, seeds=5), ledger, crew, PLACE)
    assert {trial.case for trial in crew.begun} == set(cases)
    assert len(crew.begun) == 30


def test_a_planner_that_was_good_once_is_never_given_up(ledger):
    fly(asked_for(case("b"), seeds=1), ledger, Crew(), PLACE)
    progress = fly(asked_for(case("b"), seeds=50), ledger, Fails(), PLACE)
    assert (progress.done, progress.aside, progress.notes) == (1, 49, ())


def test_a_hopeless_planner_leaves_nothing_in_the_air(ledger):
    fly(asked_for(case("b"), seeds=100), ledger, Fails(room=8), PLACE)
    assert {row["state"] for row in ledger.rows(case("b"), range(100))} == {"waiting"}


def test_millions_of_trials_begin_at_once_and_hold_little_memory(ledger):
    import tracemalloc

    class Stops(Crew):
        def ended(self, wait_s: float) -> list[Outcome]:
            raise PowerCutError

    told = []
    tracemalloc.start()
    with suppress(PowerCutError):
        fly(asked_for(*map(case, "abcdefghi"), seeds=10**8), ledger, Stops(), PLACE, told.append)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (told[0].total, told[0].done, told[0].in_air) == (9 * 10**8, 0, 0)
    assert most < 200e6


def test_seeds_are_looked_up_in_parts_and_none_is_left_out(ledger, monkeypatch):
    monkeypatch.setattr("sooner.campaigns.campaign.LOOKED_UP", 7)
    fly(Asked(((case("a"), range(3, 9)),)), ledger, Crew(), PLACE)
    ledger.write([], [Trial(case("b"), 2)])
    crew = Crew()
    fly(Asked(((case("a"), range(11)), (case("b"), range(5)))), ledger, crew, PLACE)
    order = [(trial.seed, trial.case.planner) for trial in crew.begun]
    assert order == [
        (0, "a"), (0, "b"), (1, "a"), (1, "b"), (2, "a"), (3, "b"), (4, "b"), (9, "a"), (10, "a"), (2, "b")
    ]  # fmt: skip


def test_an_answer_by_other_code_ends_the_campaign_and_is_not_kept(ledger):
    other = json.dumps(provenance(PLACE) | {"source": "0123456789abcdef"})
    with pytest.raises(DataFormatError, match=r"a worker on .* answered with other code or other maps than ours"):
        fly(asked_for(case("a")), ledger, Crew(made_by=other), PLACE)
    assert ledger.counts(case("a"), range(6)).done == 0
    crew = Crew()
    assert fly(asked_for(case("a")), ledger, crew, PLACE).done == 6
    assert [trial.seed for trial in crew.begun] == [0, 1, 2, 3, 4, 5]  # no lease was left behind


def test_a_file_beside_the_study_that_changes_while_it_flies_is_named(ledger, tmp_path):
    place = Place("work:fly", str(tmp_path))
    (tmp_path / "work.py").write_text("A = 1\n")

    class Edits(Crew):
        def ended(self, wait_s: float) -> list[Outcome]:
            (tmp_path / "work.py").write_text("A = 2\n")
            self.made_by = json.dumps(provenance(place))
            return super().ended(wait_s)

    with pytest.raises(DataFormatError, match=r"work\.py changed while the campaign flew; give the same command again"):
        fly(asked_for(case("a")), ledger, Edits(), place)


def test_what_ended_is_kept_where_the_disk_was_full_for_a_moment(ledger, monkeypatch):
    wrote = Ledger.write
    calls = []

    def full_once(self, ended, leased):
        calls.append(1)
        if len(calls) == 3:
            raise DataFormatError
        wrote(self, ended, leased)

    monkeypatch.setattr(Ledger, "write", full_once)
    with pytest.raises(DataFormatError):
        fly(asked_for(case("a")), ledger, Crew(room=1), PLACE)
    assert ledger.counts(case("a"), range(6)).done == 2
    assert [row["state"] for row in ledger.rows(case("a"), range(6))] == ["done", "done"]


def test_progress_tells_what_is_left(ledger):
    told = []
    fly(asked_for(case("a"), case("b"), seeds=4), ledger, Crew(), PLACE, told.append)
    assert (told[0].done, told[0].seconds_left) == (0, None)
    assert (told[-1].done, told[-1].seconds_left, told[-1].last_failure) == (8, 0.0, "")
    again = []
    fly(asked_for(case("a"), case("b"), seeds=8), ledger, Crew(), PLACE, again.append)
    assert again[0].done == 8
    assert again[0].seconds_left == pytest.approx(8 * 0.1 / 2)
