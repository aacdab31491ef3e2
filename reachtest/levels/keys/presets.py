"""Characters by name: the numbers that engines start a new project with.

Where an engine leaves movement to a script, its own starter script fills the row. Where it has no terminal
speed, 40 m/s is taken (Unreal's default): far above what a fall inside a level reaches, and safe to simulate.
"""

from __future__ import annotations

from reachtest.records import Character

NO_LIMIT_MPS = 40.0

DEFAULTS: dict[str, float] = {
    "terminal_speed_mps": NO_LIMIT_MPS,
    "acceleration_mps2": 20.48,
    "braking_mps2": 20.48,
    "ground_friction": 8.0,
    "air_control": 0.05,
}
"""What a character without a preset need not say: Unreal's defaults."""

PRESETS: dict[str, Character] = {
    # Unreal Engine, UCharacterMovementComponent and ACharacter defaults, in metres.
    "unreal": Character(
        radius_m=0.34,
        height_m=1.76,
        walk_speed_mps=6.0,
        jump_speed_mps=4.2,
        step_height_m=0.45,
        slope_limit_deg=44.765,
        gravity_mps2=9.8,
        terminal_speed_mps=40.0,
        acceleration_mps2=20.48,
        braking_mps2=20.48,
        ground_friction=8.0,
        air_control=0.05,
    ),
    # Unity CharacterController; the rest from the Starter Assets' FirstPersonController: SprintSpeed 6 (the
    # player's fastest), JumpHeight 1.2 at Gravity -15 (sqrt(2 * 15 * 1.2) = 6 m/s), terminal velocity 53,
    # SpeedChangeRate 10, in the air exactly as on the ground.
    "unity": Character(
        radius_m=0.5,
        height_m=2.0,
        walk_speed_mps=6.0,
        jump_speed_mps=6.0,
        step_height_m=0.3,
        slope_limit_deg=45.0,
        gravity_mps2=15.0,
        terminal_speed_mps=53.0,
        acceleration_mps2=60.0,
        braking_mps2=60.0,
        ground_friction=10.0,
        air_control=1.0,
    ),
    # Godot 4 CharacterBody3D with the default CapsuleShape3D and the template script (SPEED 5, JUMP_VELOCITY
    # 4.5), which sets the velocity outright, on the ground and in the air: full speed within one tick of
    # 1/60 s. move_and_slide has no step-up.
    "godot": Character(
        radius_m=0.5,
        height_m=2.0,
        walk_speed_mps=5.0,
        jump_speed_mps=4.5,
        step_height_m=0.0,
        slope_limit_deg=45.0,
        gravity_mps2=9.8,
        terminal_speed_mps=NO_LIMIT_MPS,
        acceleration_mps2=300.0,
        braking_mps2=300.0,
        ground_friction=60.0,
        air_control=1.0,
    ),
    # Quake III bg_pmove, 1 unit = 0.0254 m: box 30 x 30 x 56, 320 u/s, jump 270 u/s, step 18 u, gravity 800
    # u/s2, floor normal z >= 0.7; pm_accelerate 10 and pm_friction 6 (both 1/s, times 320 u/s),
    # pm_airaccelerate 1.
    "quake3": Character(
        radius_m=0.381,
        height_m=1.42,
        walk_speed_mps=8.1,
        jump_speed_mps=6.86,
        step_height_m=0.457,
        slope_limit_deg=45.57,
        gravity_mps2=20.3,
        terminal_speed_mps=NO_LIMIT_MPS,
        acceleration_mps2=81.0,
        braking_mps2=48.6,
        ground_friction=6.0,
        air_control=0.1,
    ),
}
"""One line to add one."""
