"""The general graph of a body of revolution, against the disk's own and against 25 digits."""

import copy
import pickle

import casadi as ca
import numpy as np
import pytest
import reference

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.equations import round_system


def thin_disk(k: float) -> st.Body:
    """The disk as any other body: h = sin θ."""
    return st.Body(lambda theta: ca.sin(theta), axial=2 * k, transverse=k, name="thin disk")


@pytest.mark.few(6)
@pytest.mark.parametrize(
    "known", reference.spectra(), ids=lambda s: f"{s['family']}-{s['k']}-{s['mu']}"
)
def test_general_graph_meets_the_reference_spectra(known: dict) -> None:  # type: ignore[type-arg]
    found = st.spectrum(
        known["family"],
        at=known["at"],
        body=thin_disk(known["k"]),
        contact=st.Viscous(known["mu"]),
    )
    true = np.array([complex(float(a), float(b)) for a, b in known["eigenvalues"]])
    size = np.abs(true).max()
    ours = found.eigenvalues
    assert len(ours) == len(true)
    for value in true:
        assert np.abs(ours - value).min() < 1e-11 * size
    assert found.structural_zeros == known["structural_zeros"]


@pytest.mark.few(2)
@pytest.mark.parametrize("known", reference.trajectories(), ids=lambda m: f"{m['k']}-{m['mu']}")
def test_general_graph_meets_the_reference_motions(known: dict) -> None:  # type: ignore[type-arg]
    """Five motions of the disk by an inertial formulation with quaternions."""
    assert len(reference.trajectories()) == 5
    run = st.simulate(
        thin_disk(known["k"]),
        st.Viscous(known["mu"]),
        known["start"],
        known["times"],
        tolerance=1e-13,
        check=False,
    )
    names = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
    found = np.array([run[n].values for n in names]).T
    true = np.array(known["states"])
    assert found.shape == true.shape == (len(known["times"]), 6)
    assert np.abs(found - true).max() < 1e-9


@pytest.mark.few(3)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("physical", [False, True])
def test_general_graph_is_the_disks_at_random_states(law: str, physical: bool) -> None:
    rng = np.random.default_rng(3)
    given = ("mu",) if LAWS[law].parameters else ()
    general = round_system(thin_disk(0.3), LAWS[law], given, physical=physical)
    own = st.disk_system(law)
    for _ in range(50):
        k, mu, mass, gravity, length = rng.uniform(0.1, 0.5), *rng.uniform(0.2, 2.0, 4)
        if not physical:
            mass = gravity = length = 1.0
        speed, rate = np.sqrt(gravity * length), np.sqrt(gravity / length)
        unit = np.array([1, rate, rate, rate, speed, speed])[: len(own.states)]
        x = np.array([rng.uniform(0.3, 2.8), *rng.normal(0, 0.5, len(own.states) - 1)])
        x[4:] /= 10  # far from D = 0
        numbers = {
            "axial": 2 * k,
            "transverse": k,
            "mass": mass,
            "gravity": gravity,
            "length": length,
            "mu": mu / speed,
        }
        p = [numbers[n] for n in general.parameters]
        rates = general.rates(x * unit, p) / unit / rate
        true = own.rates(x, [k, mu][: len(own.parameters)])
        assert np.abs(rates - true).max() < 1e-12 * (1 + np.abs(true).max())
        seen, known = general.observe(x * unit, p), own.observe(x, [k, mu][: len(own.parameters)])
        assert seen["energy"] == pytest.approx(known["energy"] * mass * gravity * length, rel=1e-12)
        assert seen["determinant"] == pytest.approx(known["determinant"], rel=1e-12)


def test_a_law_of_a_user_has_the_same_force_in_si() -> None:
    class Weakening(st.Contact):
        nu: float
        name = "weakening"
        parameters = (st.Parameter("nu", "s/m", lambda nu, scales: nu * scales.speed),)

        def force(self, slip, normal, nu):  # type: ignore[no-untyped-def]
            share = nu * normal / (1 + slip[0] ** 2 + slip[1] ** 2)
            return [-share * slip[0], -share * slip[1]]

    body = thin_disk(0.25)
    plain = round_system(body, Weakening, ("nu",), physical=False)
    si = round_system(body, Weakening, ("nu",), physical=True)
    x, speed, rate = np.array([1.1, 0.3, -0.2, 0.7, 0.2, -0.1]), np.sqrt(19.62), np.sqrt(9.81 / 2)
    unit = np.array([1, rate, rate, rate, speed, speed])
    true = plain.rates(x, [0.5, 0.25, 0.3])
    found = si.rates(x * unit, [0.5, 0.25, 3.0, 9.81, 2.0, 0.3 / speed]) / unit / rate
    assert found == pytest.approx(true, abs=1e-13)


SI = {"mass": 2.0, "gravity": 1.0, "length": 1.0}


def test_bodies_compare_hash_pickle_and_copy() -> None:
    body, same = st.Torus(0.2, **SI), st.Torus(0.2, **SI)
    assert body == same and hash(body) == hash(same)
    assert body != st.Torus(0.3, **SI) and body != st.Torus(0.2, solid=False, **SI)
    for again in (pickle.loads(pickle.dumps(body)), copy.deepcopy(body)):
        assert again == body
        assert again.height_at(0.4) == body.height_at(0.4)


def test_numbers_of_a_shape_are_axes_of_maps() -> None:
    found = st.stability_map(
        "rolling",
        x=("omega3", 0.1, 2, 6),
        y=("tube", 0.05, 0.5, 5),
        body=st.Torus(0.1),
        contact=st.Viscous(0.4),
    )
    assert found.verdict.dims == ("tube", "omega3")
    for tube in (0.05, 0.5):
        for omega3 in (0.1, 2.0):
            alone = st.spectrum(
                "rolling", at=omega3, body=st.Torus(tube), contact=st.Viscous(0.4), certify=True
            )
            cell = found.sel(tube=tube, omega3=omega3, method="nearest")
            assert st.Verdict(int(cell.verdict)) is alone.verdict


def test_si_numbers_give_the_same_verdicts_and_scaled_eigenvalues() -> None:
    plain = st.spectrum("tumbling", at=0.7, body=st.Torus(0.2), contact=st.Viscous(0.5))
    body = st.Torus(0.2, mass=3.0, gravity=9.81, length=0.4)
    speed, rate = np.sqrt(9.81 * 0.4), np.sqrt(9.81 / 0.4)
    si = st.spectrum("tumbling", at=0.7, body=body, contact=st.Viscous(0.5 / speed))
    assert si.eigenvalues / rate == pytest.approx(plain.eigenvalues, abs=1e-12)
    assert si.verdict is plain.verdict


def test_what_does_not_fit_is_refused_in_a_sentence() -> None:
    torus = st.Torus(0.2)
    cases = [
        (dict(family="rolling", body=torus, disk=st.Disk()), "body and disk are both given"),
        (dict(family="rolling", body="torus"), "body is 'torus'; give a stability.Body"),
        (dict(family="gliding", body=torus), "family is 'gliding'; known for torus are rolling"),
        (dict(family="rolling", body=torus, contact=None), "contact is missing"),
        (dict(family="rolling", body=torus, tube=0.3), "tube is torus's own number"),
        (dict(family="circling", body=torus, at=(1.0, 0.5)), "family of the rough contact"),
        (dict(family="spinning", body=st.ThickDisk(0.1)), "thick disk has no spinning"),
        (dict(family="spinning", body=torus, theta=1.0), "theta"),
    ]
    for given, words in cases:
        arguments = {"at": 1.0, "contact": st.Viscous(0.3)} | given
        with pytest.raises(st.StabilityError, match=words) as error:
            st.spectrum(**arguments)  # type: ignore[arg-type]
        assert "\n" not in str(error.value)
