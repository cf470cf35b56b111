"""The claims of the papers, and agreements of galvi with other codes, as executable checks."""

from collections import Counter

from benchmarks.checks.claim import Claim
from benchmarks.claims.documents import all_documents, claims_in


def _number(claim: Claim) -> tuple[int, int]:
    return "VLA".index(claim.id[0]), int(claim.id[1:])


_ALL = sorted((claim for document in all_documents() for claim in claims_in(document)), key=_number)
if _repeated := [id for id, count in Counter(claim.id for claim in _ALL).items() if count > 1]:
    raise ValueError(f"a claim has one section; those of {_repeated} have several.")
CLAIMS = tuple(claim for claim in _ALL if claim.id[0] != "A")
AGREEMENTS = tuple(claim for claim in _ALL if claim.id[0] == "A")

__all__ = ["AGREEMENTS", "CLAIMS", "Claim"]
