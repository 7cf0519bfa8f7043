"""Collects the log messages of FMUs by instance."""

from __future__ import annotations

import itertools
import logging
import weakref
from ctypes import byref
from typing import NamedTuple, Optional

import fmpy
from fmpy import fmi2
from fmpy.fmi1 import printLogMessage

LOGGER = logging.getLogger("plcfmu")


class Message(NamedTuple):
    """A message logged by an FMU."""

    instance: str
    status: int  # an fmi2Status: 0 OK, 1 Warning, 2 Discard, 3 Error, 4 Fatal
    category: str
    text: str


class Log:
    """The messages of one instance, and the callbacks through which it logs them.

    Without `memory`, the callbacks have no memory functions, which an FMU needs unless it declares
    canNotUseMemoryManagementFunctions.
    """

    def __init__(self, memory: bool = True) -> None:
        self.messages: list[Message] = []
        environment = next(_environments)
        _logs[environment] = self
        self.callbacks = fmi2.fmi2CallbackFunctions()
        self.callbacks.logger = _callback
        self.callbacks.componentEnvironment = environment
        if memory:
            self.callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
            self.callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        _add_proxy(self.callbacks)

    def take(self) -> list[Message]:
        """Returns the messages since the last call of this method."""
        taken = list(self.messages)
        self.messages.clear()
        return taken


_environments = itertools.count(1)
_logs: weakref.WeakValueDictionary[int, Log] = weakref.WeakValueDictionary()


def _log(environment: Optional[int], name: bytes, status: int, category: bytes, text: bytes) -> None:
    log = _logs.get(environment) if environment else None
    if log is None:
        # An instance created elsewhere with FMPy's own callbacks, which shares the proxy.
        printLogMessage(environment, name, status, category, text)
        return
    decoded = [(part or b"").decode("utf-8", "replace") for part in (name, category, text)]
    log.messages.append(Message(decoded[0], status, decoded[1], decoded[2]))


_callback = fmi2.fmi2CallbackLoggerTYPE(_log)


def _add_proxy(callbacks: fmi2.fmi2CallbackFunctions) -> None:
    """Formats messages in C, since a Python callback cannot have a variable number of arguments.

    FMPy has one such proxy per process, so all instances share the callback and are distinguished by their environment.
    """
    try:
        from fmpy.logging import addLoggerProxy
    except (ImportError, OSError):  # FMPy has no proxy for this platform
        return
    addLoggerProxy(byref(callbacks))
