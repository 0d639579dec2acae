"""The catalogue of effects, one file per place on the rig.

In the order to read them: screw, nut, bearings, friction, air, surroundings, local, readings, length.
"""

from __future__ import annotations

from estimator.effect import Effect
from estimator.effects.air import Radiation, RotatingConvection, StillAir
from estimator.effects.bearings import AnchorFriction, AnchorHousing, FreeFriction, FreeHousing
from estimator.effects.friction import BearingSpeedExponent, Churning, FrictionThinning, NutSpeedExponent
from estimator.effects.length import BarExpansion, Displacement, ExpansionError, ProbeExpansion, SupportYield
from estimator.effects.local import LocalHeat, LocalHeatDriving, MotorHeat
from estimator.effects.nut import NutBody, NutFriction
from estimator.effects.readings import BoardDrift, ChannelGain, ChannelOffset, SensorLag, Thermometers
from estimator.effects.screw import Conduction
from estimator.effects.surroundings import AmbientGradient, BaseDrift

STRUCTURE: tuple[type[Effect], ...] = (
    Conduction,
    StillAir,
    NutFriction,
    AnchorFriction,
    FreeFriction,
    Thermometers,
    Displacement,
)
HEAT: tuple[type[Effect], ...] = (
    RotatingConvection,
    NutBody,
    AnchorHousing,
    FreeHousing,
    NutSpeedExponent,
    BearingSpeedExponent,
    FrictionThinning,
    Churning,
    MotorHeat,
    Radiation,
    BaseDrift,
    AmbientGradient,
    LocalHeat,
    LocalHeatDriving,
)
READING: tuple[type[Effect], ...] = (
    SensorLag,
    ExpansionError,
    SupportYield,
    ProbeExpansion,
    BarExpansion,
    BoardDrift,
    ChannelOffset,
    ChannelGain,
)
CATALOGUE: dict[str, type[Effect]] = {effect.name: effect for effect in (*STRUCTURE, *HEAT, *READING)}
