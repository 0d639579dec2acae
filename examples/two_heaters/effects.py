"""What heats and cools two small bodies on a board, each with its own heater."""

from estimator.effect import Effect, Param
from estimator.terms import Heat, Link, Store

BODIES = ("body_1", "body_2")
SURFACE_M2, SIGMA, ROOM_K = 1.2e-3, 5.67e-8, 300.0


class Bodies(Effect):
    """The two bodies store heat.

    C dT/dt = sum of the heats
    """

    capacity = Param(6.8, "J/K", lo=1.0, hi=50.0, fixed=True, source="weighed: 7 g of aluminium and copper")
    noise = Param(0.005, "W/sqrt(Hz)", lo=1e-5, hi=1.0, fixed=True, source="draughts")

    def terms(self, p, u, rig):
        for body in BODIES:
            yield Store(body, p.capacity, p.noise)


class HeaterPower(Effect):
    """Each heater warms its body in proportion to what it is set to.

    q = P heater
    """

    first = Param(0.01, "W/%", lo=0.0, hi=0.1, null=0.0, source="1 W at 100 %")
    second = Param(0.01, "W/%", lo=0.0, hi=0.1, null=0.0, source="1 W at 100 %")

    def terms(self, p, u, rig):
        yield Heat("body_1", p.first * u["heater_1"])
        yield Heat("body_2", p.second * u["heater_2"])


class LossToAir(Effect):
    """The bodies lose heat to the air.

    q = g (T - T_air)
    """

    g = Param(0.05, "W/K", lo=0.0, hi=1.0, null=0.0, source="10 W/(m2 K) on 12 cm2, and the leads")

    def terms(self, p, u, rig):
        for body in BODIES:
            yield Link(body, "ambient", p.g)


class Coupling(Effect):
    """The two bodies warm each other through the board.

    q = g (T_1 - T_2)
    """

    g = Param(0.01, "W/K", lo=0.0, hi=1.0, null=0.0, source="copper and board between them, by fit")

    def terms(self, p, u, rig):
        yield Link("body_1", "body_2", p.g)


class BodyRadiation(Effect):
    """The bodies radiate to the room.

    q = 4 emissivity sigma T_room^3 A (T - T_air), T_room = 300 K: the fourth power, made straight
    """

    emissivity = Param(0.5, "1", lo=0.0, hi=1.0, null=0.0, source="0.1 bare metal ... 0.9 paint")

    def terms(self, p, u, rig):
        for body in BODIES:
            yield Link(body, "ambient", 4.0 * p.emissivity * SIGMA * ROOM_K**3 * SURFACE_M2)
