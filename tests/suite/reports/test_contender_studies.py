"""Users' contenders in every table and figure that compares integrators."""

import pytest
from matplotlib.text import Text

from benchmarks.studies import (
    ephemeris,
    free_body_drift,
    round_off,
    scaling,
)
from benchmarks.studies.free_body_drift import DriftParticipant
from benchmarks.studies.round_off import gauss
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.participants import ensemble, finest, label_beside, sampled
from galvi.problems import free_rigid_body
from references.jpl import states as jpl
from reports.contents import SECTIONS
from reports.figures.picture import draw_canvas
from reports.studies.engines import EPHEMERIS
from tests.suite.benchmarks.contenders_at_hand import BROKEN, Failing, Gauss, Inside, Raising

GALVI = scaling.ScalingParticipant("galvi degree 8, Gauss 8", gauss_collocation(8), 6)
OPEN_SECTIONS = {
    section.name: section for section in SECTIONS if section.open and not section.compared
}
# The mechanism is the same for each way of breaking; a fault's sentence is found by its beginning.
WHY = {kind.name: sentence for kind, sentence in BROKEN.items()}


def externals():
    return [Inside.of(kind()) for kind in (Gauss, Raising, Failing)]


def written_in(figure, table):
    """Every text of a figure, and of its legends."""
    return [text.get_text() for text in draw_canvas(figure, table).findobj(Text)]


@pytest.fixture(scope="module")
def studied():
    """Small tables of the open studies, with a correct external integrator and two broken ones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(round_off, "QUICK_YEARS", 100.0)
        patch.setattr(round_off, "QUICK_RUNS", 2)
        patch.setattr(scaling, "WORK", 60)
        # a contender that does not reach the target has no line in a figure
        patch.setattr(scaling, "TARGET", 1e-3)
        patch.setattr(scaling, "PARTICIPANTS", (GALVI, scaling.TRUTH))
        patch.setattr(free_body_drift, "QUICK_TURNS", 5)
        participants = [DriftParticipant("galvi degree 4", gauss_collocation(4), 0.125)]
        tables = {
            "brouwer": round_off.brouwer(True, participants=(gauss(6, 10),), externals=externals()),
            "scaling": scaling.scaling(True, bodies=(3,), orbits=2, externals=externals()),
            "free-spin": free_body_drift.free_spin(
                True, participants=participants, on_box=[], externals=externals()
            ),
        }
        assert set(tables) == set(OPEN_SECTIONS)
        return tables


@pytest.mark.slow_cases("free-spin")
@pytest.mark.parametrize("name", OPEN_SECTIONS)
def test_a_sound_integrator_has_a_line_and_a_broken_one_is_named(studied, name):
    table, study = studied[name], OPEN_SECTIONS[name]
    rows = {contender: part for contender, part in table.groupby("contender")}
    assert (rows["a gauss"]["status"] == "").all()
    for contender in ("raising", "failing"):
        assert rows[contender]["status"].iloc[-1] == WHY[contender]
    text = study.table(table)[0].to_csv()
    assert "a gauss" in text and all(WHY[contender] in text for contender in ("raising", "failing"))
    for figure in study.figures:
        assert any("a gauss" in text for text in written_in(figure, table))


def test_the_numbers_of_an_external_integrator_are_those_of_its_finest_setting(studied):
    spin = studied["free-spin"].set_index("contender").loc["a gauss"]
    body = spin[spin["problem"] == "free rigid body"]
    assert list(body["turn"]) == pytest.approx([1, 2, 5], rel=1e-2)
    assert set(body["engine"]) == {"inside:It"} and 0.0 < body["step"].iloc[0] < 0.1
    assert body["attitude_error"].iloc[-1] < 1e-2 and body["momentum_error"].max() < 1e-14
    walk = studied["brouwer"].query("contender == 'a gauss'")
    assert set(walk["member"]) == {0, 1} and walk["settings"].nunique() == 1
    assert len(studied["brouwer"].query("contender == 'raising'")["member"].unique()) == 1


def test_an_external_integrator_stands_at_every_number_of_bodies_with_every_setting(studied):
    rows = studied["scaling"].query("contender == 'a gauss'")
    assert len(rows) == 2 and rows["seconds_per_orbit"].gt(0.0).all()
    assert rows["error"].iloc[1] < 0.2 * rows["error"].iloc[0]  # 1/16 when this was written
    assert rows["share"].between(0.0, 1.0).all()


def test_the_sky_has_external_integrators_too(monkeypatch):
    if jpl.missing():
        pytest.skip(jpl.missing())
    monkeypatch.setattr(ephemeris, "displacement", lambda gm, q, v, times: 0.0 * times)
    sky = ephemeris.ephemeris_table(externals=[Inside.of(Gauss()), Inside.of(Raising())])
    rows = {contender: part for contender, part in sky.groupby("contender")}
    assert set(rows) == {ephemeris.GALVI_LABEL, ephemeris.FRAME_LABEL, "a gauss", "raising"}
    assert len(rows["a gauss"]) == len(rows[ephemeris.GALVI_LABEL]) == 30
    galvi_error, gauss_error = (
        rows[contender]["integration_error_au"].max()
        for contender in (ephemeris.GALVI_LABEL, "a gauss")
    )
    assert galvi_error < 1e-11 < gauss_error
    assert list(rows["raising"]["status"]) == [WHY["raising"]]
    assert {"contender", "status"} < set(EPHEMERIS.table(sky)[0])


def test_a_setting_is_asked_for_states_at_equal_parts():
    assert sampled(10.0, {"step": 0.3, "x": 1}, 4) == {"step": 10.0 / 32, "save_every": 8, "x": 1}
    assert sampled(10.0, {"step": 9.0}, 4) == {"step": 2.5, "save_every": 1}
    assert sampled(10.0, {"samples": 1, "tolerance": 0.1}, 4) == {"samples": 4, "tolerance": 0.1}


def test_an_integrator_with_our_name_says_where_it_is_from_and_one_that_is_slow_has_fewer_runs(
    monkeypatch,
):
    external, body = Inside.of(Gauss()), free_rigid_body()
    assert label_beside(external, ["A Gauss"]) == "a gauss, external"
    assert label_beside(external, ["a gauss 2"]) == "a gauss"
    assert finest(external, body, 3.0, 10)["save_every"] == 8
    assert len(list(ensemble(external, [body] * 3, 3.0, 10, 100))) == 3
    monkeypatch.setattr("benchmarks.work_precision.participants.ENSEMBLE_SECONDS", 0.0)
    assert len(list(ensemble(external, [body] * 3, 3.0, 10, 100))) == 1
    assert len(list(ensemble(Inside.of(Raising()), [body] * 3, 3.0, 10, 100))) == 1
