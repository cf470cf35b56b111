"""JPL's ephemeris DE421 as the start of the solar system: `python -m references.jpl.states`.

Folkner, Williams and Boggs (2009), IPN Progress Report 42-178: kilometres and days of TDB, in the
frame of the ICRF, from the barycentre of the solar system; GM constants in au^3 / day^2.
The states are written as JPL gives them. DE421 also has relativity, the Moon and asteroids, so the
barycentre of the point masses alone moves slightly.
"""

from __future__ import annotations

from importlib import resources

import numpy as np

from galvi.arrays import Array
from references.contender import EngineMissing

EPOCH = 2451544.5  # Julian day, TDB: 2000-01-01 00:00
FILE = "galvi/problems/data/solar_system.csv"
BODIES = {  # body: (its series, its GM constant); Earth is the barycentre of Earth and Moon
    "Sun": ("sun", "GMS"),
    "Mercury": ("mercury", "GM1"),
    "Venus": ("venus", "GM2"),
    "Earth": ("earthmoon", "GMB"),
    "Mars": ("mars", "GM4"),
    "Jupiter": ("jupiter", "GM5"),
    "Saturn": ("saturn", "GM6"),
    "Uranus": ("uranus", "GM7"),
    "Neptune": ("neptune", "GM8"),
    "Pluto": ("pluto", "GM9"),
}
HEADER = f"""\
# Sun, planets and Pluto at the start of the year 2000
# source: JPL DE421, read with jplephem; Earth is the Earth-Moon barycentre with the mass of both
# epoch: JD {EPOCH} TDB
# units: au, day TDB; GM in au^3/day^2
# frame: barycentric ICRF, as JPL gives it, not re-centred
# made by: python -m references.jpl.states
body,GM,x,y,z,vx,vy,vz
"""


def missing() -> str:
    """One sentence saying why DE421 cannot be read here; empty when it can."""
    try:
        import de421  # noqa: F401
        import jplephem  # noqa: F401
    except ImportError as error:
        return f"{error}. Install jplephem and de421."
    return ""


def ephemeris() -> dict[str, Array]:
    """GM (au^3/day^2), position (au) and velocity (au/day) of each body, (7,), at EPOCH.

    Raises
    ------
    ModuleNotFoundError
        Without jplephem and de421.
    """
    if missing():
        raise EngineMissing(missing(), name="jplephem")
    import de421
    from jplephem.ephem import Ephemeris

    source = Ephemeris(de421)
    rows = {}
    for body, (series, constant) in BODIES.items():
        state = np.ravel(source.position_and_velocity(series, EPOCH))
        rows[body] = np.concatenate([[getattr(source, constant)], state / source.AU])
    return rows


def states(days: Array, bodies: int = len(BODIES)) -> tuple[Array, Array]:
    """Positions (au) and velocities (au/day) of the first bodies, both (saved, bodies, 3).

    Parameters
    ----------
    days : array, shape (saved,)
        days since EPOCH; ValueError outside the years that DE421 covers
    """
    if missing():
        raise EngineMissing(missing(), name="jplephem")
    import de421
    from jplephem.ephem import Ephemeris

    source = Ephemeris(de421)
    days = np.asarray(days, dtype=np.float64)
    first, last = source.jalpha - EPOCH, source.jomega - EPOCH
    if days.min() < first or days.max() > last:
        raise ValueError(
            f"DE421 covers {first:.0f} to {last:.0f} days from JD {EPOCH}; received "
            f"{days.min():g} to {days.max():g}. Choose a shorter duration."
        )
    whole_days = np.floor(days)
    rows = []
    for series, _ in list(BODIES.values())[:bodies]:
        q, v = source.position_and_velocity(series, EPOCH + whole_days, days - whole_days)
        rows.append(np.array([q, v]) / source.AU)
    q, v = np.array(rows).transpose(1, 3, 0, 2)
    return q, v


def table(rows: dict[str, Array]) -> str:
    """The text of the data file, 17 significant digits a number."""
    lines = [",".join([body, *(f"{x:.16e}" for x in row)]) for body, row in rows.items()]
    return HEADER + "\n".join(lines) + "\n"


if __name__ == "__main__":
    target = resources.files("galvi") / "problems" / "data" / "solar_system.csv"
    with resources.as_file(target) as path:
        path.write_text(table(ephemeris()), encoding="ascii")
    print(f"wrote {FILE}")
