"""What to cite for a run: the method, the codes and the data that it used."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from galvi.input_checks import shown
from galvi.interop.release import galvi_version
from galvi.method import Galerkin
from galvi.problems.planets import EPHEMERIS as DE421
from galvi.trajectory import Trajectory

# Words in the description of a method, the only record of another code in a run -> keys to cite.
KEYS_OF_WORDS = {
    "REBOUND": ("ReinLiu2012",),
    "IAS15": ("ReinSpiegel2015",),
    "WHFast": ("ReinTamayo2015",),
    "SABA": ("ReinTamayoBrown2019",),
    "MERCURIUS": ("Rein2019",),
    "TRACE": ("Lu2024",),
    "JANUS": ("ReinTamayo2018",),
    "MuJoCo": ("Todorov2012",),
    "heyoka": ("BiscaniIzzo2021",),
    "SciPy": ("Virtanen2020",),
    "DOP853": ("Virtanen2020",),
}


@cache
def entries() -> dict[str, str]:
    """The entries of citations.bib by their keys; galvi's has VERSION in place of its version."""
    text = files("galvi.interop").joinpath("citations.bib").read_text(encoding="utf-8")
    blocks = ["@" + entry.strip().lstrip("@") for entry in text.split("\n@")]
    return {entry[entry.index("{") + 1 : entry.index(",")]: entry for entry in blocks}


@dataclass(frozen=True)
class Citation:
    """What to cite for a run.

    Attributes
    ----------
    sentence
        how the run was made, with keys in square brackets
    bibtex
        the entries of the keys

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.kepler(), method, step=0.1, steps=4)
    >>> citation = galvi.cite(run)
    >>> "[Hall2013, Miglio2016]" in citation.sentence, citation.bibtex.count("@")
    (True, 3)
    """

    sentence: str
    bibtex: str

    def __str__(self) -> str:
        return f"{self.sentence}\n\n{self.bibtex}"


def cite(run: Trajectory) -> Citation:
    """The citations of a run: of its method, and of the codes and the data that it used.

    galvi is always cited, in the installed version. Other codes are recognised by the words of
    KEYS_OF_WORDS in the description of the method; a code without such a word is named in the
    sentence but not cited.

    Parameters
    ----------
    run : galvi.Trajectory
        a run of galvi or of another code

    Returns
    -------
    galvi.Citation
        ``sentence`` and ``bibtex``

    Raises
    ------
    TypeError
        When run is not a Trajectory.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(galvi.problems.outer_solar_system(), method, step=100.0, steps=4)
    >>> "@phdthesis{Hall2013" in galvi.cite(run).bibtex
    True
    """
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    method, problem = run.method, run.problem
    if isinstance(method, Galerkin):
        keys = ["Hall2013", "Miglio2016"]
        text = (
            f"{_subject(problem.name)} was integrated with {method.name}, a Galerkin variational "
            "integrator"
        )
    else:
        keys = [
            key
            for word, keys_of_word in KEYS_OF_WORDS.items()
            if word in str(method)
            for key in keys_of_word
        ]
        text = f"{_subject(problem.name)} was integrated with {method}"
    text += f" [{', '.join(dict.fromkeys(keys))}]" if keys else ""
    text += f", using galvi {galvi_version()} [galvi]"
    keys = [*keys, "galvi"]
    if problem.parameters.get("source") == DE421:
        keys.append("Folkner2009")
        text += ", with initial states from JPL's ephemeris DE421 [Folkner2009]"
    bibtex = "\n\n".join(entries()[key] for key in dict.fromkeys(keys))
    return Citation(f"{text}.", bibtex.replace("VERSION", galvi_version()))


def _subject(name: str) -> str:
    """The subject of the sentence: the problem, with its name where it has one."""
    return f"The problem '{name}'" if name else "The problem"
