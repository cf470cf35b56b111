"""The claims of the papers as executable checks."""

from importlib import import_module
from pathlib import Path

from benchmarks.checks.claim import Claim
from benchmarks.claims.documents import claims_in

FOLDER = Path(__file__).parent


def _claims() -> tuple[Claim, ...]:
    claims = {one.id: one for path in FOLDER.glob("*/*.md") for one in claims_in(path)}
    for path in FOLDER.glob("*/[vl][0-9][0-9]_*.py"):
        letter, number = path.name[0].upper(), int(path.name[1:3])
        if f"{letter}{number}" not in claims:
            module = import_module(f"benchmarks.claims.{path.parent.name}.{path.stem}")
            claims[f"{letter}{number}"] = getattr(module, f"{letter}{number}")
    return tuple(claims[name] for name in sorted(claims, key=lambda n: (n[0] != "V", int(n[1:]))))


CLAIMS = _claims()
AGREEMENTS = claims_in(FOLDER / "agreements.md")

__all__ = ["AGREEMENTS", "CLAIMS", "Claim"]
