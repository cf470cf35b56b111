"""The claims of the papers as executable checks."""

from importlib import import_module

from benchmarks.checks.claim import Claim
from benchmarks.claims.documents import FOLDER, all_documents, claims_in


def _claims() -> tuple[Claim, ...]:
    claims = {one.id: one for document in all_documents() for one in claims_in(document)}
    for path in FOLDER.glob("*/[vl][0-9][0-9]_*.py"):
        letter, number = path.name[0].upper(), int(path.name[1:3])
        if f"{letter}{number}" not in claims:
            module = import_module(f"benchmarks.claims.{path.parent.name}.{path.stem}")
            claims[f"{letter}{number}"] = getattr(module, f"{letter}{number}")
    order = sorted(claims, key=lambda name: ("VLA".index(name[0]), int(name[1:])))
    return tuple(claims[name] for name in order)


ALL = _claims()
CLAIMS = tuple(claim for claim in ALL if claim.id[0] != "A")
AGREEMENTS = tuple(claim for claim in ALL if claim.id[0] == "A")

__all__ = ["AGREEMENTS", "CLAIMS", "Claim"]
