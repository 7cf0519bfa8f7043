"""An FMI 3.0 instance with the methods that `instance` calls on an FMI 2.0 instance, stepped without Event Mode."""

from __future__ import annotations

from typing import Any, Optional

from fmpy import fmi3
from fmpy.fmi1 import FMICallException

from .messages import Message

NUMBERS = ("Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
ERROR = 3  # fmi3Error


class Slave3(fmi3.FMU3Slave):
    """An FMI 3.0 FMU for co-simulation. Its log messages go to `messages`."""

    def __init__(self, messages: list[Message], **options: Any) -> None:
        super().__init__(**options)
        self._messages = messages
        self._start_time = 0.0

    def instantiate(self, callbacks: Any = None, loggingOn: bool = False) -> None:
        """Calls `fmi3InstantiateCoSimulation`. Ignores `callbacks`: FMI 3.0 needs only a logger, which is `_log`."""
        super().instantiate(loggingOn=loggingOn, logMessage=self._log)

    def _log(self, environment: Optional[int], status: int, category: bytes, text: bytes) -> None:
        decoded = [(part or b"").decode("utf-8", "replace") for part in (category, text)]
        self._messages.append(Message(self.instanceName, status, *decoded))

    def setupExperiment(self, startTime: float) -> None:
        """Stores the start time, which FMI 3.0 passes only on entering Initialization Mode."""
        self._start_time = startTime

    def enterInitializationMode(self) -> None:
        super().enterInitializationMode(startTime=self._start_time)

    def setString(self, references: list[int], values: list[bytes]) -> None:
        super().setString(references, [value.decode() for value in values])

    def doStep(self, t: float, h: float) -> None:
        """Calls `fmi3DoStep`. A request to end the simulation is an error, as is an early return (never permitted)."""
        _, ends, early, _ = super().doStep(t, h)
        if ends or early:
            raise FMICallException(function="fmi3DoStep", status=ERROR)
