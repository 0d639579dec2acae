"""The model as a page has it: each effect with its equation, and values with sd and unit."""

from ballscrew.page.section import Block, Formula, Grid, Section, Words
from ballscrew.terminal import Rows
from estimator.effect import Effect
from estimator.model import Model


def equations(model: Model) -> Section:
    """All effects, in the order of the model."""
    fitted = ", ".join(model.about.get("fitted_on", {}))
    head = f"{model.name}: {len(model.effects)} effects, {len(model.free())} free parameters"
    said = [f"{head}; {f'fitted on {fitted}' if fitted else 'not fitted to recordings'}."]
    blocks: list[Block] = [Words(said), *(_effect(effect, model) for effect in model.effects.values())]
    return Section("The model", blocks, new_page=True)


def _effect(effect: Effect, model: Model) -> Section:
    parameters = [Grid(_parameters(effect, model), prose=(3, 4))] if effect.params else []
    return Section(effect.name, [Words([effect.sentence()]), Formula(effect.equation()), *parameters], level=4)


def _parameters(effect: Effect, model: Model) -> Rows:
    rows = [["parameter", "value", "+- sd", "unit", "source"]]
    for key, param in effect.params.items():
        value = model.values[f"{effect.name}.{key}"]
        sd = f"{value.sd:.2g}" if value.sd is not None else ""
        rows.append([key, f"{value.value:.5g}", "fixed" if value.fixed else sd, param.unit, param.source])
    return rows
