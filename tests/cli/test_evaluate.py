import pytest


@pytest.fixture
def scored(sooner, mission):
    def score(text: str, *more):
        (mission.parent / "flight.csv").write_text(text)
        return sooner("evaluate", mission, mission.parent / "flight.csv", *more)

    return score


def test_a_bare_plan_is_scored(scored):
    told = scored("2,2\n2,3\n2,4\n", "--json").json
    weights = {(r, c): (r * c) % 7 for r in range(5) for c in range(6)}
    gained = [0.5 * weights[2, c] / sum(weights.values()) for c in (2, 3, 4)]
    assert told["value"] == pytest.approx(sum(gained))
    assert told["cdp"] == told["value"]
    assert told["mean_time_if_found"] == pytest.approx(sum(t * g for t, g in enumerate(gained)) / sum(gained))
    assert told["time_to"]["0.5"] is None
    assert told["steps"] == [2]
    assert told["duration_s"] == 4.0
    left = told["remaining"]
    assert sum(left.values()) + told["cdp"] == pytest.approx(1.0)


def test_words_are_printed_without_json(scored):
    ended = scored("2,2\n2,3\n")
    assert ended.status == 0
    assert "finds the person with probability" in ended.out
    assert "1 steps (0:02)" in ended.out


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("2,2\n2,4\n", "step 1 goes from [2, 2] to [2, 4]: they are not neighbours"),
        ("2,3\n2,4\n", "it starts at [2, 3]; the start is [2, 2]"),
        ("2,2\n" * 14, "it takes 13 steps; the budget is 12"),
        ("searcher,step,row,col\n0,0,2,2\n1,0,2,2\n", "a plan for 2 searchers came; the problem has 1"),
        ("2,2\n2,x\n", "line 2"),
        ("", "an empty file"),
    ],
)
def test_an_illegal_plan_is_refused_with_the_reason(scored, text, reason):
    ended = scored(text, "--json")
    assert ended.status == 2
    assert ended.out == ""
    assert "flight.csv" in ended.err
    assert reason in ended.err


def test_a_missing_plan_is_refused(sooner, mission):
    ended = sooner("evaluate", mission, mission.parent / "none.csv")
    assert ended.status == 2
    assert "none.csv: there is no such file" in ended.err


def test_the_authors_path_scores_what_the_author_says(sooner, wisar, tmp_path):
    (tmp_path / "mission.toml").write_text(
        f'[area]\npoc = "{wisar}/newyork53_dist.csv"\ncell_m = 24\n'
        f'[sensor]\ndifficulty = "{wisar}/newyork53_diff.csv"\n'
        "[[searcher]]\nstart = [50, 50]\nspeed_mps = 12\n[budget]\nsteps = 900\n"
    )
    path = wisar / "newyork53_T900_author_topnh_yesdiff_path.csv"
    told = sooner("evaluate", tmp_path / "mission.toml", path, "--json").json
    assert told["cdp"] == pytest.approx(0.046900, abs=5e-7)
    assert 100 * told["efficiency"] == pytest.approx(77.00, abs=0.005)
