"""A library of another platform, driven through `loader/loader.c`: what FMPy's `FMU2Slave` is to the tests for a
library of this one.

The loader runs under Wine or qemu and makes the calls that it is sent. `Slave.dll` has the 34 functions and takes
the same ctypes arguments as a loaded library does; arrays and variables come back as the library left them.

`.ci/platforms` builds the loaders into `target/platforms`, and the FMUs with these libraries into `target/platforms/fmu`.
"""

import atexit
import ctypes
import os
import pathlib
import shlex
import struct
import subprocess

from fmpy import fmi2

# The functions in the order of loader.c, each with the types of its arguments (i integer, d double, p pointer) and
# of its result.
SIGNATURES = {
    "fmi2GetTypesPlatform": ("", "s"),
    "fmi2GetVersion": ("", "s"),
    "fmi2SetDebugLogging": ("piip", "i"),
    "fmi2Instantiate": ("pippp" "ii", "p"),
    "fmi2FreeInstance": ("p", ""),
    "fmi2SetupExperiment": ("pi" "dd" "id", "i"),
    "fmi2EnterInitializationMode": ("p", "i"),
    "fmi2ExitInitializationMode": ("p", "i"),
    "fmi2Terminate": ("p", "i"),
    "fmi2Reset": ("p", "i"),
    "fmi2GetReal": ("ppip", "i"),
    "fmi2GetInteger": ("ppip", "i"),
    "fmi2GetBoolean": ("ppip", "i"),
    "fmi2GetString": ("ppip", "i"),
    "fmi2SetReal": ("ppip", "i"),
    "fmi2SetInteger": ("ppip", "i"),
    "fmi2SetBoolean": ("ppip", "i"),
    "fmi2SetString": ("ppip", "i"),
    "fmi2GetFMUstate": ("pp", "i"),
    "fmi2SetFMUstate": ("pp", "i"),
    "fmi2FreeFMUstate": ("pp", "i"),
    "fmi2SerializedFMUstateSize": ("ppp", "i"),
    "fmi2SerializeFMUstate": ("pppi", "i"),
    "fmi2DeSerializeFMUstate": ("ppip", "i"),
    "fmi2GetDirectionalDerivative": ("ppipipp", "i"),
    "fmi2SetRealInputDerivatives": ("ppipp", "i"),
    "fmi2GetRealOutputDerivatives": ("ppipp", "i"),
    "fmi2DoStep": ("pddi", "i"),
    "fmi2CancelStep": ("p", "i"),
    "fmi2GetStatus": ("pip", "i"),
    "fmi2GetRealStatus": ("pip", "i"),
    "fmi2GetIntegerStatus": ("pip", "i"),
    "fmi2GetBooleanStatus": ("pip", "i"),
    "fmi2GetStringStatus": ("pip", "i"),
    "plcfmu_interface": ("pi", "i"),
}
NUMBERS = {name: number for number, name in enumerate(SIGNATURES)}
NULL = b"p" + struct.pack("<Q", 0)


# The loader's exit code if it cannot load the library or does not understand a call.
CANNOT_LOAD = 2

BUILT = pathlib.Path(__file__).resolve().parent.parent / "target" / "platforms"

# The commands that run a program of another platform here. PLCFMU_RUNNER is that of any other one.
RUNNERS = {
    "win64": "/usr/lib/wine/wine64",
    "aarch64-linux": "qemu-aarch64 -L /usr/aarch64-linux-gnu",
}


def run(platform, program, *arguments, **options):
    """Starts a program of another platform: a `subprocess.Popen` with these options. Wine keeps its own files in
    `target/platforms/wine`."""
    runner = os.environ.get("PLCFMU_RUNNER", RUNNERS.get(platform))
    assert runner is not None, f"PLCFMU_RUNNER must say how a program for {platform} is run here"
    environment = {**os.environ, "WINEPREFIX": str(BUILT / "wine"), "WINEDEBUG": "-all", "LC_ALL": "C.UTF-8"}
    environment["WINEPATH"] = str(BUILT / "win64" / "dlls")
    command = [*shlex.split(runner), str(program), *map(str, arguments)]
    return subprocess.Popen(command, env=environment, **options)


def suffix(platform):
    """How the file name of a library ends."""
    return ".dll" if platform.startswith("win") else ".so"


def library(platform, packed):
    """The library for a platform in the FMU's folder `packed`."""
    inside = sorted((packed / "binaries" / platform).glob("*" + suffix(platform)))
    assert len(inside) == 1, f"{packed} has no library for {platform}: use the FMUs of .ci/platforms"
    return inside[0]


class Library:
    """A library in a loader of its own; every message is passed to `log`."""

    def __init__(self, platform, library, log):
        loader = BUILT / platform / ("loader.exe" if platform.startswith("win") else "loader")
        assert loader.is_file(), f"there is no {loader}: run .ci/platforms"
        self.log = log
        self.busy = False
        self.abandoned = []
        # On a busy machine Wine now and then fails to start a program. What fails later is the library's fault.
        for attempt in range(3):
            self.process = run(platform, loader, library, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            try:
                self.call("fmi2GetVersion")
                break
            except RuntimeError:
                if attempt == 2 or self.process.returncode == CANNOT_LOAD:
                    raise
        atexit.register(self.close)

    def close(self):
        if self.process.poll() is None:
            self.process.stdin.close()
            self.process.wait()

    def free(self, component):
        """Frees an instance that nobody has any more. Python may notice that in the middle of another call: then it
        is freed after that."""
        self.abandoned.append(component)
        while self.abandoned and not self.busy and self.process.poll() is None:
            self.call("fmi2FreeInstance", self.abandoned.pop())

    def __getattr__(self, function):
        if function not in NUMBERS:
            raise AttributeError(function)
        return lambda *arguments: self.call(function, *arguments)

    def call(self, function, *arguments):
        types, result = SIGNATURES[function]
        assert len(arguments) == len(types), f"{function} takes {len(types)} arguments, not {len(arguments)}"
        changed = []
        packed = [pack(argument, type, changed) for argument, type in zip(arguments, types)]
        call = struct.pack("<II", NUMBERS[function], len(packed)) + b"".join(packed)
        self.busy = True
        try:
            self.process.stdin.write(call)
            self.process.stdin.flush()
            answer = self.answer(result, changed)
        except (BrokenPipeError, EOFError):
            raise RuntimeError(f"the loader ended with {self.process.wait()} in {function}") from None
        finally:
            self.busy = False
        if self.abandoned:
            self.free(self.abandoned.pop())
        return answer

    def answer(self, result, changed):
        for _ in range(self.number("<I")):
            environment, status = self.number("<Q"), self.number("<i")
            instance, category, text = (self.text() for _ in range(3))
            self.log(environment, instance, status, category, text)
        value = self.number("<Q")
        text = self.text()
        for variable in changed:
            content = self.text()
            if variable is not None:
                ctypes.memmove(ctypes.addressof(variable), content, len(content))
        if result == "s":
            return text
        if result == "p":
            return value or None
        return ctypes.c_int(value & 0xFFFFFFFF).value

    def take(self, length):
        content = self.process.stdout.read(length)
        if len(content) != length:
            raise EOFError
        return content

    def number(self, format):
        return struct.unpack(format, self.take(struct.calcsize(format)))[0]

    def text(self):
        return self.take(self.number("<I"))


def pack(argument, type, changed):
    """An argument as the loader takes it. What the call may change is added to `changed`."""
    if type == "d":
        return b"d" + struct.pack("<d", argument)
    if type == "i":
        return b"i" + struct.pack("<q", getattr(argument, "value", int(getattr(argument, "value", argument))))
    if argument is None:
        return NULL
    if isinstance(argument, int):
        return b"p" + struct.pack("<Q", argument)
    if isinstance(argument, bytes):
        changed.append(None)
        return b"b" + struct.pack("<I", len(argument) + 1) + argument + b"\0"
    if isinstance(argument, ctypes.c_void_p):
        return b"p" + struct.pack("<Q", argument.value or 0)
    # byref(x) has x.
    variable = getattr(argument, "_obj", argument)
    if isinstance(variable, fmi2.fmi2CallbackFunctions):
        return b"c" + struct.pack("<QB", variable.componentEnvironment or 0, bool(variable.logger))
    if isinstance(variable, ctypes.Array) and variable._type_ is ctypes.c_char_p:
        strings = [
            struct.pack("<I", 0xFFFFFFFF) if text is None else struct.pack("<I", len(text)) + text for text in variable
        ]
        return b"s" + struct.pack("<I", len(strings)) + b"".join(strings)
    content = bytes(memoryview(variable).cast("B")) if ctypes.sizeof(variable) else b""
    changed.append(variable)
    return b"b" + struct.pack("<I", len(content)) + content


class Slave:
    """One instance in a library that a loader has loaded."""

    def __init__(self, library, guid, name, resources=None):
        self.dll = library
        self.guid = guid
        self.name = name
        self.resources = resources
        self.component = None

    def __getattr__(self, function):
        return getattr(self.dll, function)

    def getTypesPlatform(self):
        return self.dll.fmi2GetTypesPlatform().decode()

    def getVersion(self):
        return self.dll.fmi2GetVersion().decode()

    def instantiate(self, callbacks, loggingOn):
        self.component = self.dll.fmi2Instantiate(
            self.name.encode(), 1, self.guid.encode(), self.resources and self.resources.encode(),
            ctypes.byref(callbacks), 0, loggingOn,
        )
        assert self.component, "fmi2Instantiate gives no instance"

    def freeInstance(self):
        if self.component:
            self.dll.free(self.component)
            self.component = None
