import numpy as np
from scipy.integrate import solve_ivp

import galvi


class Adaptive:
    name = "my adaptive method"

    def supports(self, problem):
        return type(problem.system) is galvi.Canonical and problem.system.force is None

    def settings(self, problem, duration):
        return [{"tolerance": 10.0**-k} for k in (6, 9, 12)]

    def run(self, problem, duration, setting):
        d, times = problem.q0.size, np.linspace(0.0, duration, setting["samples"] + 1)

        def rates(t, y):
            return np.append(y[d:], problem.system.acceleration(y[:d], problem.t0 + t))

        tolerances = {"rtol": setting["tolerance"], "atol": setting["tolerance"]}
        start = np.append(problem.q0, problem.v0)
        found = solve_ivp(rates, (0.0, duration), start, "DOP853", times, **tolerances)
        q, v = found.y.T[:, :d], found.y.T[:, d:]
        counts = {"force_evaluations": int(found.nfev)}
        return galvi.Trajectory(
            problem, problem.t0 + times, q, problem.system.momentum(v), counts=counts
        )
