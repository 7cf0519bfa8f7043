"""Closed loops of PLC control blocks and plants, each an FMI 2.0 co-simulation FMU.

A furnace, controlled:

    import plcfmu

    with plcfmu.Fmus() as fmus:
        controller = fmus.start("CONT_C", MAN_ON=False, CYCLE=1.0, GAIN=1.2, TI=130.0)
        furnace = fmus.start("HEATER")
        result = plcfmu.simulate(
            controller,
            furnace,
            {"CONT_C.LMN": "HEATER.POWER", "HEATER.TEMP": "CONT_C.PV_IN"},
            inputs={"CONT_C.SP_INT": 80.0},
            step=1.0,
            duration=900.0,
        )
    print(result.figures("HEATER.TEMP", "CONT_C.SP_INT"))
    result.to_csv("furnace.csv")
    result.plot("furnace.png")
"""

from . import figures, find, plot
from .figures import Figure, Figures
from .find import FmuNotFoundError, fmu, fmu_names
from .instance import FmuError, Fmus, Instance, UnknownVariableError, Variable
from .loop import clock, simulate
from .parameters import CommandNotFoundError, ParameterError, params
from .program import arguments
from .programs import BuildError, build
from .result import Result
from .studies import StudyError, StudyResult, study

__all__ = [
    "BuildError",
    "CommandNotFoundError",
    "Figure",
    "Figures",
    "FmuError",
    "FmuNotFoundError",
    "Fmus",
    "Instance",
    "ParameterError",
    "Result",
    "StudyError",
    "StudyResult",
    "UnknownVariableError",
    "Variable",
    "arguments",
    "build",
    "clock",
    "figures",
    "find",
    "fmu",
    "fmu_names",
    "params",
    "plot",
    "simulate",
    "study",
]
