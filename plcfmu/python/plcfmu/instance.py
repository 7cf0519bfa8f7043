"""Running FMUs: opened by name or path, with their variables read and written by name."""

from __future__ import annotations

import contextlib
import difflib
import math
import operator
import os
import pathlib
import shutil
import zipfile
from collections.abc import Iterable, Mapping
from types import TracebackType
from typing import Any, Callable, NamedTuple, Optional, Union

import fmpy
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

from . import find
from .find import Path
from .messages import LOGGER, Log, Message
from .slave3 import NUMBERS, Slave3

STATUSES = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
WARNING, FATAL = STATUSES.index("Warning"), STATUSES.index("Fatal")


class FmuError(RuntimeError):
    """An FMU cannot be used, or refused a call. The text includes the messages logged by the FMU.

    `function` and `status` (fmi2Error and fmi3Error are 3) describe the refused call, `messages` are the logged texts.
    """

    def __init__(
        self, text: str, function: str = "", status: Optional[int] = None, messages: Iterable[Message] = ()
    ) -> None:
        self.function = function
        self.status = status
        self.messages = [message.text for message in messages]
        super().__init__(": ".join([text, "; ".join(self.messages)]) if self.messages else text)


class UnknownVariableError(KeyError):
    """An FMU has no variable with this name; the message lists similar names, or all."""

    def __str__(self) -> str:
        return str(self.args[0])


class Variable(NamedTuple):
    """A variable as declared in the model description."""

    name: str
    reference: int
    type: str  # "Real", "Integer", "Boolean" or "String"; in FMI 3.0 "Float64", "Int16", ... for the first two
    causality: str  # "input", "output", "parameter", "local", ...
    unit: Optional[str]  # physical unit, such as "degC"
    description: str
    shape: tuple[int, ...] = ()  # the size of each dimension of an array; empty for a scalar


class _Package(NamedTuple):
    """An unpacked FMU."""

    path: pathlib.Path
    folder: pathlib.Path
    version: str
    guid: str
    identifier: str
    variables: dict[str, Variable]


class Fmus:
    """The FMUs in a folder, and their instances, which are freed at the end of the `with` block.

        with plcfmu.Fmus() as fmus:
            furnace = fmus.start("HEATER", T_START=170.0)

    Without a folder, FMUs are searched for as described in `plcfmu.find`.
    """

    def __init__(self, folder: Optional[Path] = None) -> None:
        self.folder = None if folder is None else pathlib.Path(folder)
        self._packages: dict[pathlib.Path, _Package] = {}
        self._instances: list[Instance] = []

    def __enter__(self) -> Fmus:
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], traceback: Optional[TracebackType]
    ) -> None:
        self.close()

    def start(
        self,
        fmu: Path,
        settings: Optional[Mapping[str, Any]] = None,
        *,
        name: Optional[str] = None,
        start_time: float = 0.0,
        **more_settings: Any,
    ) -> Instance:
        """A new instance with these start values, initialized and ready for the first step.

        `fmu` is the name of an FMU ("CONT_C") or the path of any FMI 2.0 or 3.0 co-simulation FMU
        ("plants/my_plant.fmu"). FMI 3.0 FMUs are stepped without Event Mode; an array is a list of its elements, row by
        row. `name` distinguishes instances; it defaults to the file's name. `start_time` is in seconds. Variables whose
        names are not valid Python names, or clash with parameters of this function, go into `settings`:
        {"DI_CONT_C.GAIN": 2.0}.

        Raises FmuNotFoundError, UnknownVariableError, TypeError for a value of the wrong type, and FmuError if the FMU
        cannot be used here or refuses a value.
        """
        given = os.fspath(fmu)
        if given.lower().endswith(".fmu") or not isinstance(fmu, str):
            path = pathlib.Path(given)
            if not path.is_file():
                raise find.FmuNotFoundError(f"no {path}")
        else:
            path = find.fmu(given, self.folder)
        path = path.resolve()
        if path not in self._packages:
            self._packages[path] = _unpacked(path)
        instance = Instance(self._packages[path], name or path.stem)
        self._instances.append(instance)
        instance._start({**(settings or {}), **more_settings}, start_time)
        return instance

    def close(self) -> None:
        """Frees all instances and removes the unpacked files."""
        for instance in self._instances:
            instance.close()
        for package in self._packages.values():
            shutil.rmtree(package.folder, ignore_errors=True)
        self._instances, self._packages = [], {}


class Instance:
    """A running FMU; created by `Fmus.start`.

    `furnace["TEMP"]` reads a variable, `furnace["CYCLE"] = 0.1` writes one, and `furnace.step(t, h, POWER=50.0)`
    sets inputs and steps. `name` is the instance's name, `variables` are its variables by name.
    """

    def __init__(self, package: _Package, name: str) -> None:
        self.name = name
        self.variables = package.variables
        self._log = Log()
        self._open = False
        options = {
            "guid": package.guid,
            "modelIdentifier": package.identifier,
            "unzipDirectory": str(package.folder),
            "instanceName": name,
        }
        try:
            is_3 = package.version.startswith("3")
            self._slave = Slave3(self._log.messages, **options) if is_3 else fmi2.FMU2Slave(**options)
        except Exception as error:  # FMPy has no exception type for a library that cannot be loaded
            raise FmuError(f"{package.path}: {error}") from error
        numbers = NUMBERS if is_3 else ("Real", "Integer")
        types = (*numbers, "Boolean", "String")
        self._getters: dict[str, Callable[..., list[Any]]] = {of: getattr(self._slave, f"get{of}") for of in types}
        self._setters: dict[str, Callable[..., None]] = {of: getattr(self._slave, f"set{of}") for of in types}

    def __repr__(self) -> str:
        return f"<FMU instance {self.name}>"

    def _start(self, settings: Mapping[str, Any], start_time: float) -> None:
        try:
            self._slave.instantiate(callbacks=self._log.callbacks, loggingOn=True)
        except Exception as error:  # FMPy has no exception type for this
            raise FmuError(f"{self.name} cannot be instantiated", messages=self._log.take()) from error
        self._open = True
        self._call(self._slave.setupExperiment, startTime=start_time)
        self.set(settings)
        self._call(self._slave.enterInitializationMode)
        self._call(self._slave.exitInitializationMode)

    def close(self) -> None:
        """Terminates and frees the instance. Calling it again has no effect."""
        if not self._open:
            return
        self._open = False
        # An FMU that has refused a step may also refuse to terminate; it is freed anyway.
        with contextlib.suppress(FMICallException):
            self._slave.terminate()
        self._slave.freeInstance()

    def _call(self, function: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        """Calls the FMU. Its log messages go into the error or, on success, to the logger "plcfmu"."""
        try:
            result = function(*arguments, **options)
        except FMICallException as error:
            if error.status == FATAL:
                self._open = False  # no function may be called after this, not even to free the instance
            refused = f"{self.name}: {error.function} returned {_status(error)}"
            raise FmuError(refused, error.function, error.status, self._log.take()) from None
        if self._log.messages:
            for message in self._log.take():
                write = LOGGER.warning if message.status >= WARNING else LOGGER.info
                write("%s: %s", self.name, message.text)
        return result

    def variable(self, name: str) -> Variable:
        """A variable by name; raises UnknownVariableError, which lists similar names, or all."""
        try:
            return self.variables[name]
        except KeyError:
            near = difflib.get_close_matches(name.upper(), self.variables, 3)
            hint = f"; did you mean {' or '.join(near)}?" if near else f"; available: {', '.join(self.variables)}"
            raise UnknownVariableError(f"{self.name} has no variable {name}{hint}") from None

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __getitem__(self, name: str) -> Any:
        """The value of a variable: float, int, bool or str, depending on its type; a TIME is in seconds."""
        return self.get([name])[name]

    def __setitem__(self, name: str, value: Any) -> None:
        self.set({name: value})

    def get(self, names: Union[str, Iterable[str]]) -> dict[str, Any]:
        """The values of several variables by name, with one call per type: get("LMN LMN_P LMN_I")."""
        chosen = [self.variable(name) for name in split(names)]
        values: dict[str, Any] = {}
        for type_, getter in self._getters.items():
            group = [variable for variable in chosen if variable.type == type_ and not variable.shape]
            if group:
                got = self._call(getter, [variable.reference for variable in group])
                values.update((variable.name, _from_c(variable, value)) for variable, value in zip(group, got))
        for variable in chosen:
            if variable.shape:
                got = self._call(self._getter(variable), [variable.reference], math.prod(variable.shape))
                values[variable.name] = [_from_c(variable, value) for value in got]
            elif variable.name not in values:
                self._getter(variable)
        return {variable.name: values[variable.name] for variable in chosen}

    def _getter(self, variable: Variable) -> Callable[..., list[Any]]:
        if variable.type not in self._getters:
            raise FmuError(f"{self.name}: {variable.name} is a {variable.type}, which can be neither read nor written")
        return self._getters[variable.type]

    def set(self, values: Optional[Mapping[str, Any]] = None, /, **more_values: Any) -> None:
        """Sets variables by name, with one call per type: set(GAIN=2.0, MAN_ON=False).

        Names that are not valid Python names go into a mapping: set({"DI_CONT_C.GAIN": 2.0}).

        Raises UnknownVariableError; TypeError for a value of the wrong type; FmuError if the FMU refuses a value, with
        its reason. If any name or type is wrong, nothing is set.
        """
        groups: dict[str, list[tuple[int, Any]]] = {}
        arrays: list[tuple[Variable, list[Any]]] = []
        for name, value in {**(values or {}), **more_values}.items():
            variable = self.variable(name)
            self._getter(variable)
            if variable.shape:
                arrays.append((variable, self._elements(variable, value)))
            else:
                groups.setdefault(variable.type, []).append((variable.reference, self._to_c(variable, value)))
        for type_, group in groups.items():
            self._call(self._setters[type_], *map(list, zip(*group)))
        for variable, elements in arrays:
            self._call(self._setters[variable.type], [variable.reference], elements)

    def _elements(self, variable: Variable, values: Any) -> list[Any]:
        """The elements of an array as FMPy passes them."""
        count = math.prod(variable.shape)
        given = list(values) if isinstance(values, Iterable) and not isinstance(values, str) else None
        if given is None or len(given) != count:
            raise TypeError(f"{self.name}: {variable.name} is an array of {count} values; assign a list of that length")
        return [self._to_c(variable, value) for value in given]

    def step(self, t: float, h: float, /, **inputs: Any) -> None:
        """Sets inputs and steps from `t` to `t + h`, in seconds.

        Raises the same errors as `set`, and FmuError if the FMU refuses the step.
        """
        if inputs:
            self.set(inputs)
        self._call(self._slave.doStep, t, h)

    def _to_c(self, variable: Variable, value: Any) -> Any:
        """Converts a value for FMPy; only the type of a number changes, never its value."""
        try:
            return _CONVERSIONS[variable.type](value)
        except (TypeError, ValueError):
            article = "an" if variable.type.startswith("I") else "a"
            raise TypeError(
                f"{self.name}: {variable.name} is {article} {variable.type}, which cannot be {value!r}; "
                f"assign {_TAKES[variable.type]}"
            ) from None


def _integer_of(type_: str) -> Callable[[Any], int]:
    bits = int(type_.lstrip("UInt"))
    low, high = (0, 2**bits - 1) if type_.startswith("U") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)

    def convert(value: Any) -> int:
        whole = _integer(value)
        if not low <= whole <= high:
            raise ValueError
        return whole

    return convert


def _integer(value: Any) -> int:
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return operator.index(value)


def _boolean(value: Any) -> bool:
    if value not in (0, 1):
        raise ValueError
    return bool(value)


def _string(value: Any) -> bytes:
    if not isinstance(value, str):
        raise TypeError
    return value.encode()


_CONVERSIONS: dict[str, Callable[[Any], Any]] = {
    "Real": float,
    "Integer": _integer,
    "Boolean": _boolean,
    "String": _string,
}
_TAKES = {"Real": "a number", "Integer": "an integer", "Boolean": "True or False", "String": "a str"}
for _type in NUMBERS:
    _is_integer = "Int" in _type
    _CONVERSIONS[_type] = _integer_of(_type) if _is_integer else float
    _TAKES[_type] = f"an integer of {_type.lstrip('UInt')} bits" if _is_integer else "a number"


def _from_c(variable: Variable, value: Any) -> Any:
    if variable.type == "Boolean":
        return bool(value)
    if variable.type == "String" and not isinstance(value, str):
        return value.decode() if value is not None else ""
    return value


def _status(error: FMICallException) -> str:
    status, version = error.status, error.function[: len("fmi2")]
    return f"{version}{STATUSES[status]}" if 0 <= status < len(STATUSES) else f"the status {status}"


def split(names: Union[str, Iterable[str]]) -> list[str]:
    """Splits names that are given as a list or as one string separated by blanks."""
    return names.split() if isinstance(names, str) else list(names)


def _unpacked(path: pathlib.Path) -> _Package:
    """Reads and unpacks an FMU; raises FmuError if it cannot run here."""
    try:
        # Some tools export FMUs whose descriptions break rules of the standard; these FMUs can still be run.
        description = fmpy.read_model_description(str(path), validate=False)
    except (zipfile.BadZipFile, KeyError) as error:
        raise FmuError(f"{path} is not an FMU: {error}") from error
    except Exception as error:  # FMPy has no exception type for a bad modelDescription.xml
        raise FmuError(f"{path}: its modelDescription.xml cannot be read: {error}") from error
    version = description.fmiVersion
    if not version.startswith(("2.", "3.")) or description.coSimulation is None:
        kind = "co-simulation" if description.coSimulation is not None else "model exchange only"
        raise FmuError(f"{path} is an FMI {version} FMU for {kind}; export it as FMI 2.0 or 3.0 for co-simulation")
    clocks = [variable.name for variable in description.modelVariables if variable.type == "Clock"]
    if clocks:
        raise FmuError(f"{path} has Clocks ({', '.join(clocks[:3])}), which are not supported; export it without them")
    identifier = description.coSimulation.modelIdentifier
    _check_platform(path, identifier, version)
    integer = "Integer" if version.startswith("2") else "Int64"
    variables = {
        variable.name: Variable(
            variable.name,
            int(variable.valueReference),
            integer if variable.type == "Enumeration" else variable.type,
            variable.causality or "local",
            variable.unit or getattr(variable.declaredType, "unit", None),
            variable.description or "",
            tuple(variable.shape or ()),
        )
        for variable in description.modelVariables
    }
    folder = pathlib.Path(fmpy.extract(str(path)))
    return _Package(path, folder, version, description.guid, identifier, variables)


def _check_platform(path: pathlib.Path, identifier: str, version: str) -> None:
    """Raises FmuError if the FMU has no library for this platform."""
    with zipfile.ZipFile(path) as archive:
        libraries = [name.split("/") for name in archive.namelist() if name.startswith("binaries/")]
    platform = fmpy.platform_tuple if version.startswith("3") else fmpy.platform
    if ["binaries", platform, identifier + fmpy.sharedLibraryExtension] not in libraries:
        platforms = sorted({parts[1] for parts in libraries if len(parts) > 2 and parts[2]})
        raise FmuError(
            f"{path} has no library for {platform}; available: {', '.join(platforms) or 'none'}"
        )
