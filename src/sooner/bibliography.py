"""What we cite, each work once. Docstrings give a key in brackets, as [Lin2014, eq. (7)]."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["BIBLIOGRAPHY", "Work", "bibtex"]


@dataclass(frozen=True)
class Work:
    """One work: its kind in BibTeX's words, and its fields."""

    kind: str
    fields: tuple[tuple[str, str], ...]


def _work(kind: str, **fields: str) -> Work:
    return Work(kind, tuple(fields.items()))


BIBLIOGRAPHY: dict[str, Work] = {
    "sooner": _work(
        "software",
        author="{The sooner founders}",
        title="sooner: plans where drones look, so that a lost person is found sooner",
        year="2026",
    ),
    "Koopman1956": _work(
        "article",
        author="Koopman, Bernard O.",
        title="The theory of search. {II}. Target detection",
        journal="Operations Research",
        volume="4",
        number="5",
        pages="503--531",
        year="1956",
    ),
    "Koopman1957": _work(
        "article",
        author="Koopman, Bernard O.",
        title="The theory of search. {III}. The optimum distribution of searching effort",
        journal="Operations Research",
        volume="5",
        pages="613--626",
        year="1957",
    ),
    "Held1971": _work(
        "article",
        author="Held, Michael and Karp, Richard M.",
        title="The traveling-salesman problem and minimum spanning trees: Part {II}",
        journal="Mathematical Programming",
        volume="1",
        pages="6--25",
        year="1971",
    ),
    "Stone1975": _work(
        "book", author="Stone, Lawrence D.", title="Theory of Optimal Search", publisher="Academic Press", year="1975"
    ),
    "Fisher1978": _work(
        "article",
        author="Fisher, Marshall L. and Nemhauser, George L. and Wolsey, Laurence A.",
        title="An analysis of approximations for maximizing submodular set functions: {II}",
        journal="Mathematical Programming Study",
        volume="8",
        pages="73--87",
        year="1978",
    ),
    "Washburn1981": _work(
        "book",
        author="Washburn, Alan R.",
        title="Search and Detection",
        publisher="Military Applications Section, Operations Research Society of America",
        year="1981",
    ),
    "Wong1984": _work(
        "article",
        author="Wong, Richard T.",
        title="A dual ascent approach for {Steiner} tree problems on a directed graph",
        journal="Mathematical Programming",
        volume="28",
        pages="271--287",
        year="1984",
    ),
    "Trummel1986": _work(
        "article",
        author="Trummel, K. E. and Weisinger, J. R.",
        title="Technical note: The complexity of the optimal searcher path problem",
        journal="Operations Research",
        volume="34",
        number="2",
        pages="324--327",
        year="1986",
    ),
    "Zhou2005": _work(
        "inproceedings",
        author="Zhou, Rong and Hansen, Eric A.",
        title="Beam-stack search: Integrating backtracking with beam search",
        booktitle="Proceedings of the 15th International Conference on Automated Planning and Scheduling",
        pages="90--98",
        year="2005",
    ),
    "Bourgault2006": _work(
        "incollection",
        author="Bourgault, Fr{\\'e}d{\\'e}ric and Furukawa, Tomonari and Durrant-Whyte, Hugh F.",
        title="Optimal search for a lost target in a {Bayesian} world",
        booktitle="Field and Service Robotics",
        series="Springer Tracts in Advanced Robotics",
        volume="24",
        pages="209--222",
        publisher="Springer",
        year="2006",
    ),
    "Lin2009": _work(
        "inproceedings",
        author="Lin, Lanny and Goodrich, Michael A.",
        title="{UAV} intelligent path planning for wilderness search and rescue",
        booktitle="Proceedings of the IEEE/RSJ International Conference on Intelligent Robots and Systems (IROS)",
        pages="709--714",
        year="2009",
    ),
    "Lin2014": _work(
        "article",
        author="Lin, Lanny and Goodrich, Michael A.",
        title="Hierarchical heuristic search using a {Gaussian} mixture model for {UAV} coverage planning",
        journal="IEEE Transactions on Cybernetics",
        volume="44",
        number="12",
        pages="2532--2544",
        year="2014",
    ),
    "Kuhlman2017": _work(
        "article",
        author="Kuhlman, Michael J. and Otte, Michael W. and Sofge, Donald and Gupta, Satyandra K.",
        title="Multipass target search in natural environments",
        journal="Sensors",
        volume="17",
        number="11",
        pages="2514",
        year="2017",
    ),
    "Huangfu2018": _work(
        "article",
        author="Huangfu, Qi and Hall, J. A. Julian",
        title="Parallelizing the dual revised simplex method",
        journal="Mathematical Programming Computation",
        volume="10",
        number="1",
        pages="119--142",
        year="2018",
    ),
    "IAMSAR2019": _work(
        "manual",
        author="{International Maritime Organization and International Civil Aviation Organization}",
        title="{IAMSAR} Manual: International Aeronautical and Maritime Search and Rescue Manual",
        note="Volume {II}: Mission co-ordination; volume {III}: Mobile facilities. Doc 9731",
        year="2019",
    ),
    "Wolek2020": _work(
        "article",
        author="Wolek, Artur and Cheng, Sheng and Goswami, Debdipta and Paley, Derek A.",
        title="Cooperative mapping and target search over an unknown occupancy graph using mutual information",
        journal="IEEE Robotics and Automation Letters",
        year="2020",
    ),
}


def bibtex(key: str) -> str:
    """One entry as BibTeX.

    >>> print(bibtex("Stone1975"))
    @book{Stone1975,
      author = {Stone, Lawrence D.},
      title = {Theory of Optimal Search},
      publisher = {Academic Press},
      year = {1975},
    }
    """
    work = BIBLIOGRAPHY[key]
    lines = (f"  {name} = {{{value}}}," for name, value in work.fields)
    return "\n".join([f"@{work.kind}{{{key},", *lines, "}"])
