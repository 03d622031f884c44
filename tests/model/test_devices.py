"""Devices by name: what a scene gets of them, and that every number says where it stands and how far that was read."""

from __future__ import annotations

import pytest

import haptisym as hs

SCENE = """
title = "soft tissue"
[environment]
model = "kelvin-voigt"
k = "200 N/m"
b = "4 N*s/m"
[device]
{}
"""


def test_a_scene_with_a_device_is_the_scene_with_its_mass_damping_and_friction_written_out() -> None:
    by_name = hs.parse_scene(SCENE.format('like = "one-axis"\namplitude = "5 cm"'))
    effects = (
        hs.effects.shunt(m="0.032 kg", b="3.62 N*s/m", name="device"),
        hs.effects.coulomb_friction("0.024 N", "5 cm", name="device-friction"),
    )
    assert by_name.effects == hs.Scene(by_name.environment, effects).effects
    assert hs.parse_scene(SCENE.format('like = "one-axis"')).effects[0].name == "device"


def test_what_a_scene_writes_goes_before_what_was_read() -> None:
    scene = hs.parse_scene(SCENE.format('like = "touch"\nm = "45 g"'))
    assert [x.value for x in scene.effects[0].parameters if x.key == "m"] == [hs.parse_scene(
        SCENE.format('like = "one-axis"\nm = "0.045 kg"')
    ).effects[0].parameters[0].value]  # fmt: skip


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('like = "tuch"', 'unknown device "tuch": did you mean "touch"'),
        ('like = "touch"', 'touch: neither mass nor damping was read: give them, as m = "45 g"'),
        ('like = "phri-master"\namplitude = "1 cm"', "its friction was not read: give it"),
        ('m = "1 kg"', "like is missing: give the name of a device"),
        ('like = "one-axis"\nmass = "1 kg"', 'unknown key "mass"'),
        ('like = "one-axis"\nm = "3 N"', 'm: "3 N" is not a mass'),
        ("like = 3", 'unknown device "3"'),
    ],
)
def test_what_a_device_may_not_be_is_refused_with_the_way_out(table: str, words: str) -> None:
    with pytest.raises(hs.SceneError) as error:
        hs.parse_scene(SCENE.format(table))
    assert words in str(error.value)


def test_every_number_has_a_source_and_says_how_far_that_was_read() -> None:
    assert len(hs.devices) >= 15
    for device in hs.devices.values():
        assert device
        for number in device.values():
            assert number.value > 0
            assert len(number.source) > 20
            assert number.read
            assert "recalled" not in number.source + number.read


def test_a_number_that_was_not_read_is_not_there() -> None:
    assert "m" not in hs.devices["touch"]
    with pytest.raises(hs.SceneError, match="its m was not read; known are force, stiffness, damping"):
        hs.devices["touch"]["m"]


@pytest.mark.parametrize("name", [*hs.scene_names(), *hs.family_names()])
def test_a_shipped_scene_whose_numbers_are_illustrative_says_so_in_its_title(name: str) -> None:
    scenes = hs.load_scenes(name)
    is_so = "illustrative" in scenes.source or "recalled" in scenes.source
    assert is_so is scenes.title.endswith("(illustrative)")
