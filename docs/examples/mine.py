import numpy as np

import galvi


class Leapfrog:
    name = "my leapfrog"
    order = 2
    conserves = {"energy": 1e-3}

    def supports(self, problem):
        known = isinstance(problem.system, (galvi.Canonical, galvi.NBody))
        return known and getattr(problem.system, "force", None) is None

    def settings(self, problem, duration):
        return [{"step": duration / n, "save_every": n} for n in (1000, 4000, 16000)]

    def run(self, problem, duration, setting):
        h, every, q, v = setting["step"], setting["save_every"], problem.q0, problem.v0
        saved = [(q, v)]
        for k in range(round(duration / h)):
            q = q + 0.5 * h * v
            v = v + h * problem.system.acceleration(q, problem.t0 + (k + 0.5) * h)
            q = q + 0.5 * h * v
            saved += [(q, v)] if (k + 1) % every == 0 else []
        q, v = np.swapaxes(saved, 0, 1)
        t, p = problem.t0 + h * every * np.arange(len(q)), problem.system.momentum(v)
        counts = {"steps": k + 1, "force_evaluations": k + 1}
        return galvi.Trajectory(problem, t, q, p, counts=counts)
