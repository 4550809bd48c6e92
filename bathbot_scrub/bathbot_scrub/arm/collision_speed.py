"""How fast an arm may go where somebody may be: by what a body bears when it is hit, and what a brush gives.

A body part of mass m_H and stiffness k that is hit at v takes up the energy of the relative motion as a
spring, v = F / sqrt(mu k) with the reduced mass mu = (1/m_H + 1/m_R)^-1 and m_R = M/2 + m_L of the arm's
moving parts and its load (ISO/TS 15066:2016, by way of `collision_table`, with what is said there of the
numbers). F is the quasi-static bound: the table allows a face no more, however short.

The head bears less: its bristles must not be used up while the arm notices, turns round and comes away as
fast as the body comes after it.
"""

from math import sqrt

from bathbot_scrub.arm.collision_table import BodyPart, parts_of


def impact_speed(part: BodyPart, moving: float, load: float) -> float:
    """Largest speed [m/s] at which an arm of `moving` mass and `load` [kg] may hit a body part."""
    arm = moving / 2.0 + load
    reduced = 1.0 / (1.0 / part.mass + 1.0 / arm)
    return part.quasi_static / sqrt(reduced * part.stiffness)


def collision_speed(region: str, moving: float, load: float) -> float:
    """The same [m/s] for a class of skin; the least of all where it is unknown."""
    return min(impact_speed(part, moving, load) for part in parts_of(region))


def meeting_speed(room: float, delay: float, deceleration: float, body: float) -> float:
    """Largest speed [m/s] of a head towards a body that comes at `body` [m/s]; 0 where none is slow enough.

    They close in on each other at c: for `delay` [s] unchanged, then slower by `deceleration` [m/s^2] until
    the head recedes as fast as the body comes, c delay + c^2 / (2 a) farther on. That must fit into `room`
    [m], what is left of the bristles' give once the touch is felt.
    """
    closing = deceleration * (sqrt(delay**2 + 2.0 * max(room, 0.0) / deceleration) - delay)
    return max(closing - body, 0.0)
