"""Detection and tracking over streets by dense matrices over pairs of nodes, written from the paper's equations."""

import numpy as np


def pairs_of(graph, detected):
    """The explored states, as pairs of nodes."""
    moving = [tuple(edge) for edge in graph.explored_edges(detected).tolist()]
    rest = [(int(node), int(node)) for node in np.flatnonzero(detected)]
    return rest + moving + [(b, a) for a, b in moving]


def walk_matrix(graph, detected, walk):
    """Q[s, s'] = q_walk(s | s') over explored states, eq. (1) and (2) with weights over explored neighbours."""
    pairs = pairs_of(graph, detected)
    matrix = np.zeros((len(pairs), len(pairs)))
    for column, (before, node) in enumerate(pairs):
        on = [row for row, (p, c) in enumerate(pairs) if p == node and c != node]
        if not on:
            matrix[pairs.index((node, node)), column] = 1.0
            continue
        rest = walk.rest_again if before == node else walk.rest
        matrix[pairs.index((node, node)), column] = rest
        weights = []
        for row in on:
            if before == node:
                weights.append(1.0)
                continue
            was, goes = (graph.positions_m[c] - graph.positions_m[p] for p, c in ((before, node), pairs[row]))
            cosine = was @ goes / np.sqrt((was @ was) * (goes @ goes))
            turn = np.arccos(np.clip(cosine, -1.0, 1.0))
            above = (walk.turn_shape - walk.turn_scale / np.pi) * turn + 1 + walk.turn_scale
            weights.append(above / (1 + walk.turn_shape * turn))
        matrix[on, column] = (1 - rest) * np.array(weights) / sum(weights)
    return pairs, matrix


def one_second(pairs, matrix, present, absent, log_of_node, absent_p, decay):
    """(p(s), p(phi)) after eq. (10) to (13), from those before and the log likelihood ratio of each node."""
    vanish, appear = decay * absent_p, decay * (1 - absent_p) / max(len(pairs), 1)
    predicted = appear * absent + (1 - vanish) * matrix @ present
    predicted_absent = (1 - appear * len(pairs)) * absent + vanish * present.sum()
    seen = predicted * np.exp([log_of_node.get(c, 0.0) for _, c in pairs])
    total = seen.sum() + predicted_absent
    return seen / total, predicted_absent / total
