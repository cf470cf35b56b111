"""What is contradicted of the papers, in a sentence for each claim: for README and start page."""

from __future__ import annotations

import textwrap

CONTRADICTIONS = {
    "V14": "the last sentence of H's theorem 2.3.7 has C_f^-1 where C_f^(-1/2) follows; false only "
    "where C_f grows as h tends to 0.",
    "V21": "M's sqrt(2 + 1/N) should be sqrt(2 + 1/(N - 1)) for Lobatto's N nodes; with N + 1 the "
    "ratio is 1.",
    "V22": "M's rules of M + 1 nodes err by h^2 less than printed, and its order 2 N - 2 is 2 N: "
    "an index slip, on the safe side.",
    "V27": "H's 1.2.3 has the constant of the squared norms; M's beta >= h should be sqrt(h).",
    "V28": "M's N^-s is the rate in L^2; the norm with a derivative has one power less.",
}
WIDTH = 101  # columns of the README


def contradictions() -> str:
    """As a Markdown list."""
    return "\n".join(
        textwrap.fill(f"- {name}: {text}", WIDTH, subsequent_indent="  ")
        for name, text in CONTRADICTIONS.items()
    )
