#!/usr/bin/env python3
"""The weights of src/detection/evidence.rs, by logistic regression (needs numpy).

usage: fit.py TOOLS SHARED.jsonl TWIN.jsonl...
TOOLS: the folder of score_detect.py (../shared/tools). SHARED: what the example score_weights prints for ../shared/scenes.
TWIN: the same for scenes of the twin, which count half and have a constant of their own. Prints, for depth and image
before and after a fit, the weights of the terms, both constants, and recall and precision with an eighth of the scenes
of SHARED left out in turn.
"""
import json
import os
import sys

import numpy as np

TWIN_COUNTS = 0.5


def labelled(path, source, stage, hit):
    """Terms, whether a countable cylinder is hit, number of the scene; and how many there are to find."""
    rows, count, scenes = [], 0, 0
    for number, line in enumerate(open(path)):
        data = json.loads(line)
        with open(os.path.join(data["scene"], "truth.json")) as file:
            truth = json.load(file)
        bodies, used, scenes = truth["cylinders"], set(), number + 1
        count += sum(body["countable"] for body in bodies)
        for found in sorted(data[source][stage], key=lambda one: -one["score"]):
            cylinder = found["cylinder"]
            hits = [(h, k) for k, body in enumerate(bodies) if k not in used and (h := hit(cylinder, body))]
            if hits:
                best = min(hits)[1]
                used.add(best)
                if bodies[best]["countable"]:
                    rows.append((found["terms"], 1.0, number))
            elif any(hit(cylinder, body) and body["countable"] for body in bodies):
                rows.append((found["terms"], 0.0, number))
            elif not any(hit(cylinder, body) for body in bodies + truth["ignore"]):
                rows.append((found["terms"], 0.0, number))
    terms, right, scene = zip(*rows)
    return np.array(terms), np.array(right), np.array(scene), count


def regression(x, y, weight, ridge):
    b = np.zeros(x.shape[1])
    for _ in range(60):
        p = 1 / (1 + np.exp(-np.clip(x @ b, -30, 30)))
        gradient = x.T @ (weight * (y - p)) - ridge * b
        hessian = (x * (weight * (p * (1 - p) + 1e-9))[:, None]).T @ x + np.diag(ridge)
        step = np.linalg.solve(hessian, gradient)
        b += step * min(1, 3 / np.abs(step).max())
    return b


def main():
    sys.path.insert(0, sys.argv[1])
    from score_detect import hit

    for source in ("depth", "image"):
        for stage in ("before", "after"):
            own = labelled(sys.argv[2], source, stage, hit)
            twin = [labelled(path, source, stage, hit) for path in sys.argv[3:]]
            use = [k for k in range(7) if not (source == "depth" and k == 5 or stage == "before" and k == 6)]
            scale = np.vstack([part[0][:, use] for part in (own, *twin)]).std(0) + 1e-9

            def design(part, domain):
                n = len(part[0])
                return np.c_[part[0][:, use] / scale, np.ones(n), np.full(n, domain)]

            others = np.vstack([design(part, 1.0) for part in twin])
            right = np.concatenate([part[1] for part in twin])
            ridge = np.r_[np.ones(len(use)), 1e-6, 0.3]

            def fitted(kept):
                x = np.vstack([design(own, 0.0)[kept], others])
                weight = np.r_[np.ones(kept.sum()), np.full(len(right), TWIN_COUNTS)]
                return regression(x, np.r_[own[1][kept], right], weight, ridge)

            b = fitted(np.ones(len(own[1]), bool))
            weights = np.zeros(7)
            weights[use] = b[: len(use)] / scale
            print(source, stage, "terms", np.round(weights, 2).tolist())
            print("  constant %.2f, of the twin %.2f" % (b[-2], b[-2] + b[-1]))
            score = np.zeros((2, len(own[1])))
            for eighth in range(8):
                kept = own[2] % 8 != eighth
                b = fitted(kept)
                for domain in (0, 1):
                    score[domain, ~kept] = design(own, float(domain))[~kept] @ b
            for name, logit in zip(("constant", "of the twin"), score):
                found = logit > 0
                hits = own[1][found].sum()
                print("  left out, %s: recall %.3f precision %.3f" % (name, hits / own[3], hits / found.sum()))


main()
