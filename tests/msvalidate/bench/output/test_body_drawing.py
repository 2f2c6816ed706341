"""`plot`: what is drawn where, and what its title says of it."""

import re

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import msvalidate as ms
from msvalidate.bench.output import body_drawing


def loaded(dim):
    box = ms.Box((1.0, 2.0, 1.0)[:dim])
    material = ms.Isotropic(
        1e5, 1 / 3 if dim == 2 else 1 / 4, "plane_stress" if dim == 2 else "solid"
    )
    pull = ms.Traction(box.side("top"), (0.0, 10.0, 0.0)[:dim])
    held = ms.Support(box.side("bottom"), (0.0,) * dim)
    lattice = ms.square(box, (2, 4)) if dim == 2 else ms.fill(ms.patterns.cubic18(), box, (2, 4, 2))
    return ms.lattice_network(ms.Problem(box, material, (held,), (pull,)), lattice)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("given", [None, 7.0])
def test_springs_are_drawn_at_rest_and_moved_as_the_title_says(dim, given):
    network = loaded(dim)
    rest = ms.equilibrium(network)
    (axis,) = ms.plot(network, rest, magnification=given).axes
    title = axis.get_title(loc="left")
    times, most = map(float, re.findall(r"magnified (\S+) times, the largest is (\S+) m", title)[0])
    lengths = np.linalg.norm(rest.displacement, axis=1)
    assert most == pytest.approx(lengths.max(), rel=5e-3)
    assert times == given or 0.04 < times * lengths.max() / 2.0 <= 0.1
    lines = {each.get_label(): each for each in axis.collections}
    for label, at in (("undeformed", network.points), ("springs", rest.position)):
        at = network.points + times * (at - network.points)  # noqa: PLW2901
        drawn = lines[label].get_segments() if dim == 2 else lines[label]._segments3d
        assert np.allclose(np.array(drawn), at[network.springs]), "z is drawn upwards"
    assert {"held", "load"} <= set(axis.get_legend_handles_labels()[1])


def test_lines_of_bodies_stand_out_and_arrows_are_few():
    """Contrast of 3 to 1 or more with white, as WCAG 2 asks of graphics."""
    for colour in (body_drawing.AT_REST, body_drawing.DEFORMED):
        c = np.array(to_rgb(colour))
        linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
        assert 1.05 / (linear @ [0.2126, 0.7152, 0.0722] + 0.05) >= 3
    assert 4 < len(body_drawing.loaded_points(np.ones((101, 2)))) <= 12


def test_what_fits_no_network_is_refused_in_a_line():
    network = loaded(2)
    (axis,) = ms.plot(network).axes
    assert {each.get_label() for each in axis.collections}.isdisjoint({"undeformed"})
    for displacement, times, said in (
        (np.zeros((3, 2)), 1.0, r"displacement: shape \(3, 2\); give \(15, 2\)"),
        (np.full((15, 2), np.nan), 1.0, r"displacement: nan at index \(0, 0\)"),
        (np.zeros((15, 2)), 0.0, "magnification: 0.0; it must be above zero"),
    ):
        with pytest.raises(ms.ProblemError, match=said):
            ms.plot(network, displacement, magnification=times)
