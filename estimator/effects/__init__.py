"""The catalogue of effects, one file per place on the rig."""

from __future__ import annotations

from estimator.effect import Effect
from estimator.effects.air import RotatingConvection, StillAir
from estimator.effects.bearings import AnchorFriction, AnchorHousing, FreeFriction, FreeHousing
from estimator.effects.nut import NutBody, NutFriction
from estimator.effects.readings import Displacement, Thermometers
from estimator.effects.screw import Conduction, ExpansionError

CATALOGUE: dict[str, type[Effect]] = {
    effect.name: effect
    for effect in (
        Conduction,
        StillAir,
        RotatingConvection,
        NutFriction,
        NutBody,
        AnchorFriction,
        AnchorHousing,
        FreeFriction,
        FreeHousing,
        Thermometers,
        Displacement,
        ExpansionError,
    )
}
