"""Whether a Nystrom method is its own adjoint."""

from __future__ import annotations

import numpy as np

from galvi.rules.rule import Rule
from galvi.tableau import Tableau


def is_symmetric(table: Tableau, rule: Rule) -> bool:
    """Whether a step forward and a step backward cancel on vector spaces.

    The adjoint's matrix A*_kj = A_kj - beta_j + (1 - c_k) b_j equals A with its stages reversed.
    """
    adjoint = table.A - table.beta + np.outer(1.0 - table.c, table.b)
    mirrored = np.allclose(adjoint, table.A[::-1, ::-1], rtol=0.0, atol=1e-13)
    return bool(mirrored and rule.symmetric)
