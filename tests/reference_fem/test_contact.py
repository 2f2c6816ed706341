"""`reference_fem.contact`: elements against obstacles, beside values of independent programs."""

from __future__ import annotations

import re

import numpy as np
import pytest

from msvalidate.problem import (
    Box,
    Contact,
    Isotropic,
    Obstacle,
    Problem,
    ProblemError,
    Region,
    SolverError,
    Support,
)
from reference_fem.contact import contact_mesh, press, press_closely
from reference_fem.first_mesh import first_mesh
from reference_fem.mesh.boxes import box_discretisation, lines_discretisation
from reference_fem.mesh.elements import of_dimension

E, R = 8 / 3, 100.0
BLOCKS = {(10, 20): (0.998481, 1.001526, 0.0198272, 0.4531697),
          (5, 10): (0.993969, 1.006147, 0.0163955, 0.5645671)}  # fmt: skip
"""Half its width and height, in half-widths of the half-plane's patch -> half-width, peak pressure
over that of the half-plane, approach; force of a punch over E times its way. Spectral and hp
elements of an independent program, to 3e-6."""


def half_block(W, H, contact):
    box = Box((float(W), float(H)))
    held = Support(box.side("bottom"), (0.0, 0.0)), Support(box.side("left"), (0.0, None))
    return Problem(box, Isotropic(E, 1 / 3), held, contacts=(contact(box),))


@pytest.mark.parametrize(("size", "known"), BLOCKS.items())
def test_patch_and_punch_on_finite_blocks(size, known):
    W, H = size
    parabola = Obstacle("parabola", (0.0, float(H)), (0.0, -1.0), R)
    force = np.pi * E / (8 * R)
    problem = half_block(W, H, lambda box: Contact(box.side("top"), parabola, force=force))
    found, error = press_closely(problem)
    last = found[-1]
    values = last.half_width, last.pressure.max() / (E / 2 / R), last.depth
    np.testing.assert_allclose(values, known[:3], rtol=1e-3)
    assert np.abs(np.array(values) / known[:3] - 1).max() < error
    assert last.total == pytest.approx(force)
    flat = Obstacle("half_space", (0.0, float(H)), (0.0, -1.0))
    part = Region(((0.0, 1.0), float(H)))
    problem = half_block(W, H, lambda _: Contact(part, flat, 0.01))
    near = np.r_[0, np.cumsum(1.6 ** np.arange(16))]
    near = near / near[-1]
    x = np.unique(np.r_[1 - near, 1 + near, 2 + (W - 2) * np.linspace(0, 1, 9)[1:]])
    y = np.unique(np.r_[H - 2 * near, np.linspace(0, H - 2, 9)[:-1]])
    punch = press(problem, lines_discretisation([x, y], "Q2"))
    assert 2 * punch.total / (E * 0.01) == pytest.approx(known[3], rel=1e-3)


@pytest.mark.parametrize("element", of_dimension(2))
def test_a_flat_obstacle_presses_evenly(element):
    box = Box((0.74, 0.37))
    held = Support(box.side("bottom"), (None, 0.0)), Support(Region((0.0, 0.0)), (0.0, None))
    flat = Obstacle("half_space", (0.0, 0.37), (0.0, -1.0))
    material = Isotropic(E, 0.0, thickness=0.2)
    contact = (Contact(box.side("top"), flat, 1e-9),)
    problem = Problem(box, material, held, contacts=contact)
    found = press(problem, box_discretisation(box, (6, 3), element))
    np.testing.assert_allclose(found.pressure, 1e-9 * E / 0.37, rtol=1e-12)
    assert found.total == pytest.approx(1e-9 * E * 2 * 0.2)


@pytest.mark.parametrize("size", [0.37, 370.0])
@pytest.mark.parametrize("element", sorted({*of_dimension(2), *of_dimension(3)} - {"S2"}))
def test_the_total_is_the_force(element, size):
    plane, degree = element[0] in "QP", int(element[1])
    box = Box((2 * size, size) if plane else (2 * size, 2 * size, size))
    cells = np.array((16, 8) if plane else (8, 8, 4)) // degree
    material = Isotropic(E, 0.3, thickness=0.2) if plane else Isotropic(E, 0.3, "solid")
    shape, sides = ("disc", ("bottom", "top")) if plane else ("ball", ("back", "front"))
    way = np.eye(box.dim)[-1]
    obstacle = Obstacle(shape, box.size - (1 - way) * size, -way, 4 * size)
    clamp, top = (box.side(name) for name in sides)
    for strain in (0.05, 0.3):
        force = strain * E * size * (0.2 if plane else size)
        contact = Contact(top, obstacle, force=force)
        problem = Problem(box, material, (Support(clamp, (0.0,) * box.dim),), contacts=(contact,))
        found = press(problem, box_discretisation(box, tuple(cells.tolist()), element))
        assert found.total == pytest.approx(force, rel=1e-9)
        assert found.depth > 0


@pytest.mark.parametrize("strain", 10.0 ** np.arange(-10, -1, 2))
def test_hertz_by_force_over_eight_decades(strain):
    """Half-width b² = 4 F R/(π E t) of a half-plane.

    The patch ends between two of 8 nodes, and 0.4 W beside a block's side is a half-plane to
    (b/0.4 W)². Smaller forces leave a patch of less than 1e-5 W.
    """
    W, thickness = 0.37, 0.2
    force, b = strain * E * W * thickness, np.sqrt(4 * strain / np.pi) * W
    box = Box((W, W))
    contact = Contact(box.side("top"), Obstacle("disc", (0.4 * W, W), (0.0, -1.0), W), force=force)
    clamp = Support(box.side("bottom"), (0.0, 0.0))
    material = Isotropic(E, 1 / 3, thickness=thickness)
    found, error = press_closely(Problem(box, material, (clamp,), contacts=(contact,)), (2, 4))
    assert found[-1].total == pytest.approx(force, rel=1e-9)
    values = found[-1].half_width / b, found[-1].pressure.max() / (E * b / (2 * W))
    assert values == pytest.approx((1, 1), abs=(1 / 8) ** 2 + (b / 0.4 / W) ** 2)
    assert np.abs(np.array(values) - 1).max() <= error + (b / 0.4 / W) ** 2


def test_a_disc_pressed_by_a_force_is_one_lowered_by_the_depth_that_it_takes():
    disc = Obstacle("disc", (0.0, 1.0), (0.0, -1.0), 2.0)
    problem = half_block(2, 1, lambda box: Contact(box.side("top"), disc, force=0.05))
    body = contact_mesh(problem, 0.4, 6)
    found = press(problem, body)
    again = half_block(2, 1, lambda box: Contact(box.side("top"), disc, found.depth))
    lowered = press(again, body)
    assert lowered.total == pytest.approx(0.05, rel=1e-3)
    near = press(again, body, within=0.1)  # too near, so that all may touch
    np.testing.assert_allclose(near.pressure, lowered.pressure, rtol=1e-9, atol=1e-12)


def test_contacts_that_elements_do_not_take_are_refused():
    disc = Obstacle("disc", (0.0, 1.0), (0.0, -1.0), 2.0)
    for contact, message in (
        (lambda box: Contact(box.side("top"), disc, -0.1), "no point of the region can be reached"),
        (lambda box: Contact(box.side("top"), disc, 0.1, friction=0.2), "friction 0.2 of elements"),
    ):
        problem = half_block(2, 1, contact)
        with pytest.raises(ProblemError, match=re.escape(message)):
            press(problem, first_mesh(problem))
    beside = Obstacle("disc", (3.0, 1.0), (0.0, -1.0), 0.3)
    problem = half_block(2, 1, lambda box: Contact(box.side("top"), beside, force=0.01))
    with pytest.raises(ProblemError, match="no point of the region can be reached"):
        press(problem, box_discretisation(problem.domain, (8, 4), "Q2"))
    problem = half_block(2, 1, lambda box: Contact(box.side("top"), disc, force=1e-4))
    with pytest.raises(SolverError, match="the patch has 1 nodes, and smaller elements are needed"):
        press(problem, box_discretisation(problem.domain, (8, 4), "Q2"))
    problem = half_block(2, 1, lambda box: Contact(box.side("top"), disc, 0.1))
    bare = Problem(problem.domain, problem.material, problem.supports)
    with pytest.raises(ProblemError, match="0 contacts; elements take one"):
        press(bare, first_mesh(bare))
