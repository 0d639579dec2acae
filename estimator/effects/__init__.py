"""The catalogue of effects, one file per place on the rig.

In the order to read them: screw, nut, bearings, friction, air, surroundings, local, readings, length,
held; elsewhere, which is in no model but moves what the others do.
"""

from estimator.effect import Effect
from estimator.effects import air, bearings, friction, held, length, local, nut, readings, screw, surroundings

STRUCTURE: tuple[type[Effect], ...] = (
    screw.Conduction,
    air.StillAir,
    nut.NutFriction,
    bearings.AnchorFriction,
    bearings.FreeFriction,
    readings.Thermometers,
    length.Displacement,
)
MOUNTING: tuple[type[Effect], ...] = (held.HeldEnds,)
HEAT: tuple[type[Effect], ...] = (
    air.FreeConvection,
    air.RotatingConvection,
    nut.NutBody,
    nut.NutBalls,
    nut.NutFlange,
    bearings.AnchorSeat,
    bearings.FreeSeat,
    bearings.AnchorHousing,
    bearings.FreeHousing,
    bearings.HousingShells,
    friction.WarmGrease,
    friction.NutSpeedExponent,
    friction.BearingSpeedExponent,
    friction.FrictionThinning,
    friction.Churning,
    local.MotorHeat,
    air.Radiation,
    surroundings.BaseDrift,
    surroundings.AmbientGradient,
    local.LocalHeat,
    local.LocalHeatDriving,
)
READING: tuple[type[Effect], ...] = (
    readings.SensorLag,
    length.ExpansionError,
    length.SupportYield,
    length.ProbeExpansion,
    length.BarExpansion,
    readings.BoardDrift,
    readings.ChannelOffset,
    readings.ChannelGain,
)
CATALOGUE: dict[str, type[Effect]] = {effect.name: effect for effect in (*STRUCTURE, *MOUNTING, *HEAT, *READING)}
