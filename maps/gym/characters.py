"""Whom the exercises are for: every preset, and numbers of one's own."""

from __future__ import annotations

from dataclasses import replace

from reachtest.levels import PRESETS

CUSTOM = replace(
    PRESETS["unreal"],
    radius_m=0.25,
    height_m=1.2,
    walk_speed_mps=4.0,
    jump_speed_mps=5.5,
    slope_limit_deg=35.0,
)
GIANT = replace(
    PRESETS["unreal"],
    radius_m=0.6,
    height_m=2.6,
    walk_speed_mps=7.0,
    jump_speed_mps=5.0,
    step_height_m=0.7,
    slope_limit_deg=50.0,
)
CHARACTERS = {**PRESETS, "custom": CUSTOM, "giant": GIANT}
