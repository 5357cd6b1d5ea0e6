"""Scenes in TOML files: what they state, and what they are refused for."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.bodies.newton_euler import STATES
from stability.bodies.quantities import PHYSICAL
from stability.bodies.resistance import RESISTANCES
from stability.scene import toml_file
from stability.scene.toml_file import LARGEST, read, titled

FOLDER = Path(__file__).parents[2] / "examples" / "scenes"
EXAMPLES = sorted(FOLDER.glob("*.toml"))
CONTACT = '[contact]\nlaw = "viscous"\nmu = 0.3\n'
START = "[start]\ntheta = 1.4\n"
QUESTION = "[question]\nhorizon = 5.0\n"
WHOLE = CONTACT + START + QUESTION


def written(folder: Path, text: str) -> Path:
    path = folder / "a scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_states_the_arguments_of_a_scene(tmp_path: Path) -> None:
    title, given = titled(
        written(
            tmp_path,
            """
        title = "A roll"
        [disk]
        mass = 0.3
        radius = 0.45
        gravity = 9.81
        k = 0.5
        [contact]
        law = "coulomb-regularised"
        mu = 0.2
        epsilon = 1e-3
        [start]
        theta = 1.4
        omega3 = 3           # a whole number is a number
        [question]
        horizon = 5
        tolerance = 1e-4
        quantities = ["outcome", "final"]
        [uncertain]
        mu = 0.2
        theta = 1e-3
    """,
        )
    )
    disk, law = given.pop("disk"), given.pop("contact")
    assert title == "A roll"
    assert (disk.mass, disk.radius, disk.gravity, disk.k) == (0.3, 0.45, 9.81, 0.5)
    assert type(law) is st.RegularisedCoulomb
    assert law.given == {"mu": 0.2, "epsilon": 1e-3}
    assert given == {
        "start": {"theta": 1.4, "omega3": 3.0},
        "horizon": 5.0,
        "tolerance": 1e-4,
        "quantities": ("outcome", "final"),
        "uncertain": {"mu": 0.2, "theta": 1e-3},
    }


def test_what_a_file_leaves_out_has_the_default_of_a_scene(tmp_path: Path) -> None:
    path = written(tmp_path, WHOLE)
    title, given = titled(path)
    assert title == "a scene"
    assert set(given) == {"disk", "contact", "start", "horizon"}
    scene = st.Scene.from_toml(path)
    assert scene.disk.dimensionless
    assert (scene.tolerance, scene.quantities, scene.uncertain) == (1e-6, ("final",), {})


def test_a_named_disk_and_a_family_are_those_of_python(tmp_path: Path) -> None:
    coin = st.Disk.named("quarter")
    text = CONTACT + QUESTION + '[disk]\nname = "quarter"\n[start]\nat = 0.3\nfamily = "tumbling"\n'
    given = read(written(tmp_path, text))
    assert given["disk"].mass == coin.mass
    assert np.array_equal(given["start"], st.launch("tumbling", at=0.3, disk=coin))
    given = read(written(tmp_path, text + "tilt = 0.05\n"))
    assert given["start"][0] == pytest.approx(0.25, abs=1e-15)


def test_each_table_in_contact_is_a_law_named_like_it_unless_it_says_another(
    tmp_path: Path,
) -> None:
    laws = read(
        written(
            tmp_path,
            START
            + QUESTION
            + """
        [contact.rough]
        [contact.sticky]
        law = "viscous"
        mu = 30
        [contact.linear-viscous]
        c = 0.02
    """,
        )
    )["contact"]
    assert {n: type(law) for n, law in laws.items()} == {
        "rough": st.Rough,
        "sticky": st.Viscous,
        "linear-viscous": st.LinearViscous,
    }
    assert laws["sticky"].mu == 30.0
    assert laws["linear-viscous"].given == {"c": 0.02}


def test_marks_and_line_ends_of_other_systems_are_read(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + WHOLE.replace("\n", "\r\n").encode())
    assert read(path)["contact"].mu == 0.3


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_an_example_is_a_scene_with_a_title(path: Path) -> None:
    title, _ = titled(path)
    assert title != path.stem
    assert isinstance(st.Scene.from_toml(path), st.Scene)
    first = path.read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("# ")


def test_the_examples_are_seven() -> None:
    assert len(EXAMPLES) == 7


# --- what the comments of the examples say ---


def _example(stem: str, **changed: Any) -> st.Scene:
    return replace(st.Scene.from_toml(FOLDER / f"{stem}.toml"), **changed)


def _tilts(stem: str, times: Any, **changed: Any) -> Any:
    scene = _example(stem, **changed)
    run = st.simulate(scene.disk, scene.contact, scene.start, times, tolerance=1e-10, check=False)
    return np.abs(np.pi / 2 - run.theta.values)


@pytest.mark.long
def test_the_spun_coin_sways_ever_more_as_its_file_says() -> None:
    """The sway is the largest tilt in a quarter of a second, which is three of its periods."""
    about = np.linspace(-0.125, 0.125, 251)
    sway = {t: _tilts("spun-coin", t + about).max() for t in (1, 3, 8, 18)}
    assert sway[1] == pytest.approx(0.001, abs=2e-4)
    assert sway[8] == pytest.approx(0.011, abs=5e-4)
    assert sway[18] == pytest.approx(0.4, abs=0.02)
    scene = _example("spun-coin")
    spectrum = st.spectrum("spinning", at=90.0, disk=scene.disk, contact=scene.contact)
    assert spectrum.verdict.word == "unstable"
    assert sway[3] / sway[1] == pytest.approx(math.exp(2 * spectrum.abscissa), rel=0.1)
    assert math.log(2) / spectrum.abscissa == pytest.approx(2, abs=0.05)
    growing = max(spectrum.eigenvalues, key=lambda value: (value.real, value.imag))
    assert growing.imag / (2 * math.pi) == pytest.approx(14, abs=0.5)
    longer = replace(scene, horizon=30.0, uncertain={}).answer()
    assert longer.model == "viscous"
    assert 20 < longer.until < 30


@pytest.mark.long
def test_the_disk_near_the_threshold_lifts_off_on_both_sides_of_it() -> None:
    scene = _example("near-threshold-roll")
    for at, end in ((1.384, 45.2), (1.414, 56.2), (1.444, 70.4)):
        run = st.simulate(scene.disk, scene.contact, st.launch("rolling", at=at, tilt=0.05), 80.0)
        assert run.attrs["outcome"] == "lift-off"
        assert float(run.end_time) == pytest.approx(end, abs=0.05)
    spread = replace(scene, horizon=80.0).answer().spread
    assert spread is not None
    assert spread.contrary == ()
    laws = [st.Viscous(1e-3), st.Viscous(0.3), st.Viscous(1e4), st.Rough()]
    for law, value in zip(laws, [2**0.5] * 3 + [3**-0.5], strict=True):
        [point] = st.boundaries("rolling", axis=("at", 0.2, 3.0, 101), contact=law)
        assert float(point.value) == pytest.approx(value, rel=1e-12)


@pytest.mark.long
def test_the_other_changes_that_the_files_propose_do_what_they_say() -> None:
    raised = _example("hoop-on-a-rough-floor", raise_tolerance=True).answer()
    assert raised.model == "creep-1"
    assert raised.tolerance > 1e-4
    slippery = _example("eulers-disk").answer(only="creep")
    assert slippery.model == "none"
    times = np.linspace(0, 8, 801)
    assert times[_tilts("eulers-disk", times).argmax()] == pytest.approx(4, abs=0.1)
    half = np.linspace(0, 0.5, 501)
    sway = _tilts("rolled-coin", half, contact=st.Viscous(1.0), weights={}).max()
    assert sway > _tilts("rolled-coin", half, contact=st.Smooth(), weights={}).max()


# --- what is refused ---

REFUSED = [
    ("", "is empty; a scene needs the tables [contact], [start] and [question]"),
    ("# only words\n", "is empty"),
    (CONTACT + "theta = \n", "is not TOML: Invalid value (at line 4"),
    (CONTACT + '\n[start]\nfamily = "rol', "(at line 6, the last)"),
    (CONTACT + CONTACT, "is not TOML: Cannot declare ('contact',) twice (at line 4"),
    ("a = " + "[" * 100_000, "nested too deeply"),
    ("a = " + "1" * 10_000, "too many digits"),
    ("a = 0\n" * 200_000, "more than 1 MiB"),
    (WHOLE + "[colour]\n", "the file has 'colour'; known are title, disk, body, contact, start"),
    (CONTACT + QUESTION, "[start] is missing"),
    (START + QUESTION, "[contact] is missing"),
    (CONTACT + START, "[question] is missing"),
    ("start = 3\n" + CONTACT + QUESTION, "start is 3; give a table, under a line [start]"),
    ("title = 3\n" + WHOLE, "title is 3; give a text"),
    (WHOLE + "[[disk]]\n", "disk is [{}]; give a table"),
    (WHOLE + "[disk]\nwidth = 1\n", "[disk] has 'width'; known are name, mass, radius, gravity, k"),
    (WHOLE + "[disk]\nname = 'euro'\n", "disk is 'euro'; known are quarter"),
    (WHOLE + "[disk]\nname = 2\n", "name of [disk] is 2; give a text"),
    (WHOLE + "[disk]\nname = 'quarter'\nk = 0.5\n", "[disk] has name and k"),
    (WHOLE + "[disk]\nmass = 1.0\n", "the disk has mass and no radius; give mass, radius and"),
    (WHOLE + "[disk]\nk = 0.7\n", "k is 0.7; a thin body has"),
    (WHOLE + "[disk]\nk = 'thin'\n", "k of [disk] is 'thin'; a real number is needed"),
    (WHOLE + "[disk]\nk = nan\n", "k of [disk] is nan; a finite number is needed"),
    (WHOLE + "[disk]\nk = true\n", "k of [disk] is True; a real number is needed"),
    (WHOLE + "[disk]\nk = [0.25, 0.5]\n", "k of [disk] has shape (2,); give one number"),
    (WHOLE + "[disk]\nk = 2026-01-01\n", "a real number is needed"),
    ("[contact]\n" + START + QUESTION, "[contact] has no law; give one"),
    ("[contact]\nlaw = 'glue'\n" + START + QUESTION, "contact is 'glue'; known are smooth"),
    ("[contact]\nlaw = 3\n" + START + QUESTION, "law of [contact] is 3; give a text"),
    ("[contact]\nlaw = 'viscous'\n" + START + QUESTION, "[contact] has no mu; the viscous law"),
    ("[contact]\nlaw = 'linear-viscous'\n" + START + QUESTION, "[contact] has no c or mu"),
    (
        CONTACT + "nu = 3\n" + START + QUESTION,
        "[contact] with the viscous law has 'nu'; known are law, mu",
    ),
    ("[contact]\nlaw = 'rough'\nmu = 1\n" + START + QUESTION, "has 'mu'; known are law."),
    ("[contact]\nlaw = 'viscous'\nmu = -1\n" + START + QUESTION, "mu is -1; friction must be"),
    ("[contact]\nlaw = 'viscous'\nmu = inf\n" + START + QUESTION, "mu of [contact] is inf"),
    ("[contact]\nlaw = 'no_such:Law'\n" + START + QUESTION, "cannot be imported"),
    (
        "[contact]\nmu = 1\n[contact.rough]\n" + START + QUESTION,
        "[contact] has 'mu' and the table 'rough'",
    ),
    ("[contact.glue]\n" + START + QUESTION, "contact is 'glue'; known are smooth"),
    ("[contact.viscous]\n" + START + QUESTION, "[contact.viscous] has no mu"),
    (CONTACT + QUESTION + "[start]\n", "[start] has no theta"),
    (CONTACT + QUESTION + "[start]\nomega3 = 2\n", "[start] has no theta"),
    (WHOLE + "[uncertain]\ntheta = 'a bit'\n", "theta of [uncertain] is 'a bit'"),
    (CONTACT + QUESTION + START + "spin = 1\n", "[start] has 'spin'; known are theta"),
    (CONTACT + QUESTION + START + "family = 'rolling'\n", "[start] has family and theta"),
    (CONTACT + QUESTION + "[start]\nfamily = 'rolling'\n", "[start] has no at"),
    (CONTACT + QUESTION + "[start]\nat = 1\n", "[start] has no family"),
    (CONTACT + QUESTION + "[start]\nat = 1\nfamily = 'flying'\n", "family is 'flying'; known"),
    (CONTACT + QUESTION + "[start]\nat = 1\nfamily = ['rolling']\n", "family is ['rolling']"),
    (CONTACT + QUESTION + "[start]\nat = 1\nfamily = 'rolling'\ntilt = 2\n", "the tilt takes"),
    (CONTACT + START + "[question]\ntolerance = 1e-3\n", "[question] has no horizon"),
    (CONTACT + START + QUESTION + "method = 'rk4'\n", "[question] has 'method'; known are"),
    (CONTACT + START + QUESTION + "quantities = 3\n", "quantities of [question] is 3"),
    (CONTACT + START + QUESTION + "quantities = ['final', 3]\n", "give names, such as"),
]


@pytest.mark.parametrize(("text", "sentence"), REFUSED)
def test_a_file_that_states_something_else_is_refused_in_a_sentence(
    text: str, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(st.StabilityError) as told:
        read(written(tmp_path, text))
    assert sentence in str(told.value)
    assert "a scene.toml" in str(told.value)
    assert "--mu" not in str(told.value)  # a file has keys, not options
    assert "--set" not in str(told.value)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (START + QUESTION + "quantities = []\n", "quantities is empty; known are final"),
        (START + QUESTION + "quantities = ['colour']\n", "quantities is 'colour'; known are"),
        (START + QUESTION + "tolerance = 3\n", "tolerance is 3; give one from"),
        (START + "[question]\nhorizon = -1\n", "horizon is -1; give a last time above 0"),
        (START + QUESTION + "[uncertain]\nnu = 1\n", "uncertain names 'nu'; known are"),
        (START + QUESTION + "[uncertain]\nmu = 0\n", "uncertain mu is 0; give a half-width"),
    ],
)
def test_what_no_scene_accepts_is_refused_by_the_scene(
    more: str, sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(st.StabilityError) as told:
        st.Scene.from_toml(written(tmp_path, CONTACT + more))
    assert sentence in str(told.value)


def test_a_file_that_is_not_there_or_is_no_text_is_refused(tmp_path: Path) -> None:
    binary = tmp_path / "b.toml"
    binary.write_bytes(b"title = 'a'\nmore = '\xff'\n")
    long = tmp_path / "long.toml"
    long.write_bytes(b"#" * (LARGEST + 1))
    for path, sentence in (
        (tmp_path / "none.toml", "is not a file"),
        (tmp_path, "is not a file"),
        (binary, "is not UTF-8 text (at line 2)"),
        (long, "more than 1 MiB"),
        ("a\0b", "leave out NUL"),
        (math.pi, "give a string or a path"),
    ):
        with pytest.raises(st.StabilityError, match="[.]$") as told:
            read(path)  # type: ignore[arg-type]
        assert sentence in str(told.value)


def test_the_page_of_the_file_names_every_key() -> None:
    page = (FOLDER.parents[1] / "docs" / "explanation" / "scene-file.md").read_text()
    of_file = *toml_file.LAUNCH, *toml_file.WHICH, *toml_file.QUESTION
    keys = {*STATES, *of_file, *PHYSICAL, *RESISTANCES, "k", "title", "weight"}
    assert {key for key in keys if f"`{key}`" not in page} == set()
    assert {table for table in toml_file.TABLES[1:] if f"[{table}" not in page} == set()
