"""Closed loops.

Every loop is wired like a PLC program. In each communication step, from t to t + step,

1. the controllers are stepped, in order: their calls at t use the process values at t;
2. a row is recorded: what the controllers read and returned in their calls at t;
3. the plants are stepped, in order, over the same time with the manipulated values from these calls.

With the plants stepped first, the loop would also work, but with one more step of dead time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Callable, Optional, Union

from tqdm import tqdm

from .instance import Instance, split
from .result import Result

Input = Union[float, Callable[[float], Any], Sequence[tuple[float, float]]]
Recorded = Union[str, Callable[[float], Any]]


def clock(duration: float, step: float, title: str = "") -> Iterator[float]:
    """The times 0, step, 2 step, ... before `duration`, in seconds; with a progress bar on a terminal."""
    if not step > 0.0 or not duration >= 0.0:
        raise ValueError(
            f"step={step}, duration={duration}: the step must be greater than 0, and the duration must not be negative"
        )
    for number in tqdm(range(round(duration / step)), desc=title or None, unit=" steps", disable=None):
        yield number * step


def simulate(
    controllers: Union[Instance, Sequence[Instance]],
    plants: Union[Instance, Sequence[Instance]],
    connections: Mapping[str, Union[str, Sequence[str]]],
    *,
    step: float,
    duration: float,
    inputs: Optional[Mapping[str, Input]] = None,
    record: Union[None, str, Iterable[str], Mapping[str, Recorded]] = None,
    title: str = "",
) -> Result:
    """Runs a closed loop for `duration` seconds in steps of `step` seconds, from time 0.

    Variables are named INSTANCE.VARIABLE, such as "CONT_C.LMN".

    - `connections`: from one variable to another, or to several: {"CONT_C.LMN": "HEATER.POWER"}. An FMU sees the
      outputs of the FMUs before it from this step, and those of the FMUs after it from the previous step.
    - `inputs`: values that no FMU provides. A constant; a list of steps, [(0.0, 170.0), (60.0, 180.0)], each held from
      its time in seconds; or a function of time, called just before a controller's step or, for a plant, after the
      controllers' steps, so that it may read other instances: {"CONT_C.SP_INT": lambda t: 0.5 * pump["FLOW"]}.
    - `record`: the variables in the result; by default, the inputs and the connected outputs. A mapping renames them,
      and accepts functions of time: {"PV": "CONT_C.PV", "SUM": lambda t: a["LMN"] + b["LMN"]}.
    - `title`: the label of the progress bar.

    Raises ValueError for a wrongly wired loop, UnknownVariableError, and FmuError with the FMU's message.
    """
    loop = _Loop(_listed(controllers), _listed(plants))
    for source, destinations in connections.items():
        for destination in [destinations] if isinstance(destinations, str) else destinations:
            loop.connect(source, destination)
    for destination, value in (inputs or {}).items():
        loop.give(destination, _function(value, step))
    if record is None:
        record = [*(inputs or {}), *connections]
    columns: Mapping[str, Recorded] = record if isinstance(record, Mapping) else {name: name for name in split(record)}
    result = Result()
    readers = {}
    for column, recorded in columns.items():
        readers[column] = loop.reader(recorded)
        if isinstance(recorded, str):
            instance, name = loop.find(recorded)
            variable = instance.variable(name)
            result.describe(column, variable.unit, variable.type == "Boolean", recorded in (inputs or {}))
    for t in clock(duration, step, title):
        for controller in loop.controllers:
            loop.set_inputs(controller, t)
            controller.step(t, step)
        for plant in loop.plants:
            loop.evaluate(plant, t)
        result.add(t, {column: read(t) for column, read in readers.items()})
        for plant in loop.plants:
            loop.set_inputs(plant, t, evaluate=False)
            plant.step(t, step)
    return result


class _Loop:
    """The wiring of a loop."""

    def __init__(self, controllers: list[Instance], plants: list[Instance]) -> None:
        self.controllers, self.plants = controllers, plants
        self.instances: dict[str, Instance] = {}
        for instance in [*controllers, *plants]:
            if instance.name in self.instances:
                raise ValueError(
                    f"two FMUs of the loop are named {instance.name}: give one of them a different name, as in "
                    f'fmus.start("{instance.name}", name="{instance.name}_2")'
                )
            self.instances[instance.name] = instance
        # All three by the receiving instance's name, then by its variable: the source, the function of time, and the
        # function's value in the current step.
        self.connected: dict[str, dict[str, tuple[Instance, str]]] = {name: {} for name in self.instances}
        self.functions: dict[str, dict[str, Callable[[float], Any]]] = {name: {} for name in self.instances}
        self.given: dict[str, dict[str, Any]] = {name: {} for name in self.instances}

    def find(self, signal: str) -> tuple[Instance, str]:
        """Splits INSTANCE.VARIABLE into the instance and the variable's name; both may contain dots."""
        for name in sorted(self.instances, key=len, reverse=True):
            if signal.startswith(f"{name}."):
                variable = self.instances[name].variable(signal[len(name) + 1 :])
                return self.instances[name], variable.name
        raise ValueError(
            f"{signal!r} is not a variable of this loop: write INSTANCE.VARIABLE with one of the instances "
            f"{', '.join(self.instances)}"
        )

    def connect(self, source: str, destination: str) -> None:
        instance, name = self._receiver(destination)
        self.connected[instance.name][name] = self.find(source)

    def give(self, destination: str, function: Callable[[float], Any]) -> None:
        instance, name = self._receiver(destination)
        self.functions[instance.name][name] = function

    def _receiver(self, destination: str) -> tuple[Instance, str]:
        instance, name = self.find(destination)
        if name in self.connected[instance.name] or name in self.functions[instance.name]:
            raise ValueError(f"{destination} gets its value from two sources; remove one of them")
        return instance, name

    def evaluate(self, instance: Instance, t: float) -> None:
        functions = self.functions[instance.name]
        self.given[instance.name] = {name: function(t) for name, function in functions.items()}

    def set_inputs(self, instance: Instance, t: float, evaluate: bool = True) -> None:
        if evaluate:
            self.evaluate(instance, t)
        connected = self.connected[instance.name]
        values = {name: source[variable] for name, (source, variable) in connected.items()}
        instance.set({**values, **self.given[instance.name]})

    def reader(self, source: Recorded) -> Callable[[float], Any]:
        """A function that reads the value of a column. An input is recorded as set, not as rounded by the FMU."""
        if not isinstance(source, str):
            return source
        instance, name = self.find(source)
        if name in self.functions[instance.name]:
            return lambda _: self.given[instance.name][name]
        return lambda _: instance[name]


def _listed(instances: Union[Instance, Sequence[Instance]]) -> list[Instance]:
    return [instances] if isinstance(instances, Instance) else list(instances)


def _function(value: Input, step: float) -> Callable[[float], Any]:
    """Converts an input to a function of time in seconds."""
    if callable(value):
        return value
    if not isinstance(value, Sequence):
        constant = value
        return lambda _: constant
    steps = sorted(value, key=lambda pair: pair[0])
    # The times of a run are computed as multiples of the step, with rounding errors: 3 * 0.1 is not 0.3.
    tolerance = 1e-6 * step
    if not steps or steps[0][0] > tolerance:
        raise ValueError(f"the steps of an input must begin at time 0, as in [(0.0, 170.0), (60.0, 180.0)]: {value!r}")

    def at(t: float) -> Any:
        return [held for since, held in steps if t >= since - tolerance][-1]

    return at
