"""Learn from generated streets where streets go on, and write what `StreetContinuation` ships with.

python benchmarks/simulation/learn_streets.py --maps 50 --to src/sooner/belief/street_continuation.csv

Joint search flies over every map once and believes in kriged nodes; every five seconds of its first 130 the unseen
cells are marked, and the map says which of them hold a node. No real map is used. What is learnt is tried on maps of
other seeds: mean log-loss of a constant, of kriging, of the model.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from sklearn.neural_network import MLPClassifier

from sooner.belief import StreetContinuation, StreetModel
from sooner.scenarios import STREET_KINDS, street_grid
from sooner.simulation import Estimator, Keep, Scene, World, simulate
from sooner.simulation.strategies import Joint

CELLS, SECONDS = 250, 130  # of each moment; of each flight


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument(
        "--maps", type=int, default=50, help="of each kind to learn from; a quarter as many to try it on"
    )
    asked.add_argument("--first", type=int, default=20000, help="the first map's seed")
    asked.add_argument("--units", type=int, default=12)
    asked.add_argument("--to", type=Path, required=True)
    said = asked.parse_args()
    marks, held, _ = moments(range(said.first, said.first + said.maps))
    model = learnt(marks, held, said.units)
    model.write(said.to)
    later = said.first + 1000
    model, (marks, held, kriged) = StreetModel.read(said.to), moments(range(later, later + said.maps // 4))
    print(f"{len(held)} cells: log-loss of their mean {loss(np.full(len(held), held.mean()), held):.4f}", end=", ")
    print(f"kriged {loss(1.0 - kriged, held):.4f}, learnt {loss(expected(model, marks), held):.4f}")


def moments(seeds: range) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k, 37) marks of unseen cells, whether each held a node, and the kriged probability that it was void."""
    rng, marks, held, kriged = np.random.default_rng(seeds.start), [], [], []
    for kind in STREET_KINDS:
        for seed in seeds:
            world = World(street_grid(kind, seed), n_targets=0)
            streets = StreetContinuation(world.grid)
            scene = Scene(world, estimator=Estimator(prior="kriged"))
            flown = simulate(scene, Joint(streets=False), seed, Keep(beliefs_s=5))
            found, kept = flown.node_seconds, flown.beliefs
            for second, void, explored in zip(kept.seconds, kept.void, kept.explored, strict=True):
                unseen = np.flatnonzero(~explored)
                if second > SECONDS or not len(unseen) or rng.random() < 0.5:
                    continue
                told = streets.marks(void, explored, (found >= 0) & (found <= second))
                some = rng.choice(unseen, min(CELLS, len(unseen)), replace=False)
                marks.append(told[some].astype(np.float32))
                held.append(world.nodes[some])
                kriged.append(void[some])
    return np.concatenate(marks), np.concatenate(held), np.concatenate(kriged)


def learnt(marks: np.ndarray, held: np.ndarray, units: int) -> StreetModel:
    """Fitted to marks made alike in scale, and told for marks as they are."""
    mean, scale = marks.mean(axis=0), marks.std(axis=0) + 1e-6
    fitted = MLPClassifier((units,), max_iter=14, batch_size=512, alpha=1e-4, random_state=0)
    fitted.fit((marks - mean) / scale, held)
    hidden = fitted.coefs_[0] / scale[:, None]
    return StreetModel(
        hidden, fitted.intercepts_[0] - mean @ hidden, fitted.coefs_[1][:, 0], float(fitted.intercepts_[1][0])
    )


def expected(model: StreetModel, marks: np.ndarray) -> np.ndarray:
    """(k,) probability of a node."""
    log_odds = np.maximum(marks @ model.hidden + model.offsets, 0.0) @ model.output + model.bias
    return 1.0 / (1.0 + np.exp(-log_odds))


def loss(told: np.ndarray, held: np.ndarray) -> float:
    p = np.clip(told, 0.005, 0.995)
    return float(-np.where(held, np.log(p), np.log(1.0 - p)).mean())


if __name__ == "__main__":
    main()
