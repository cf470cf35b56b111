"""Built-in laws of motion, see galvi.kernels.lanes.elementary."""

from __future__ import annotations

from galvi.kernels.lanes.elementary import sine_cosine


def planar_chain(n):
    """The law of galvi.kernels.forces.planar_chain for n links, with its constants."""

    def law(q, v, t, c):
        seen = [sine_cosine(x) for x in q]
        forces, momenta, mass = [], [], []
        aligned = [[0.0] * n for _ in range(n)]
        crossed = [[0.0] * n for _ in range(n)]
        for i in range(n):
            aligned[i][i] = c[n * i + i]
            for j in range(i):
                A = c[n * i + j]
                (si, ci), (sj, cj) = seen[i], seen[j]
                aligned[i][j] = aligned[j][i] = A * (ci * cj + si * sj)
                crossed[i][j] = A * (si * cj - ci * sj)
                crossed[j][i] = -crossed[i][j]
        for i in range(n):
            momentum, across = aligned[i][i] * v[i], 0.0
            for j in range(n):
                if j != i:
                    momentum = momentum + aligned[i][j] * v[j]
                    across = across + crossed[i][j] * v[j]
            momenta.append(momentum)
            forces.append(-(v[i] * across) - c[n * n + i] * seen[i][0])
            mass.append(aligned[i][: i + 1])
        return forces, momenta, mass

    return law
