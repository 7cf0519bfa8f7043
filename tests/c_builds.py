"""FMUs of blocks whose library is their own C: what the tests of the library in Rust are run over a second time.

    python tests/c_builds.py target/fmu FOLDER

makes them, and beside them the libraries alone (`lib/libcont_c.so`), which `PLCFMU_LIBRARIES` gives to the tests in Rust."""

import ctypes
import pathlib
import shutil
import subprocess
import sys
import zipfile

import fmpy

ROOT = pathlib.Path(__file__).parents[1]
# Those of FMI for one that is compiled without a prefix.
HEADERS = pathlib.Path(fmpy.__file__).parent / "c-code"
OPTIONS = ["-O2", "-shared", "-fPIC", "-DDISABLE_PREFIX", f"-I{HEADERS}"]

TOLD = """
#include <stddef.h>
#include <string.h>
static const unsigned char json[] = {%s};
size_t plcfmu_interface(char *buffer, size_t size);
size_t plcfmu_interface(char *buffer, size_t size) {
    if (buffer != NULL) {
        memcpy(buffer, json, size < sizeof json ? size : sizeof json);
    }
    return sizeof json;
}
"""


def sources(path):
    """The names of the C files in an FMU."""
    with zipfile.ZipFile(path) as fmu:
        return [name for name in fmu.namelist() if name.startswith("sources/") and name.endswith(".c")]


def told(library):
    """What a library says of itself, as JSON."""
    interface = ctypes.CDLL(str(library)).plcfmu_interface
    interface.restype, interface.argtypes = ctypes.c_size_t, [ctypes.c_char_p, ctypes.c_size_t]
    buffer = ctypes.create_string_buffer(interface(None, 0))
    interface(buffer, len(buffer))
    return buffer.raw


def as_c(library):
    """What a library says of itself, as a C file."""
    return TOLD % ",".join(str(byte) for byte in told(library))


def library_in(unpacked, name):
    """The library for this machine in the folder of an FMU."""
    is_newer = fmpy.read_model_description(str(unpacked)).fmiVersion.startswith("3")
    binaries = unpacked / "binaries" / (fmpy.platform_tuple if is_newer else fmpy.platform)
    return binaries / f"{name}{fmpy.sharedLibraryExtension}"


def joined(paths, folder):
    """A library of the C of several FMUs of one block, each of another version of FMI, in a folder."""
    name, files = pathlib.Path(paths[0]).stem, []
    for path in paths:
        unpacked = folder / f"of{len(files)}"
        fmpy.extract(str(path), str(unpacked))
        files += [unpacked / file for file in sources(path)]
    (folder / "told.c").write_text(as_c(library_in(folder / "of0", name)))
    library = folder / f"lib{name.lower()}{fmpy.sharedLibraryExtension}"
    subprocess.run(["gcc", "-std=c99", *OPTIONS, *files, folder / "told.c", "-o", library], check=True)


def compiled(path, folder, compiler=("gcc", "-std=c99")):
    """The FMU at `path` with its C as the library for this machine, in a folder."""
    path, folder = pathlib.Path(path), pathlib.Path(folder)
    name, unpacked = path.stem, folder / f".{path.stem}"
    unpacked.mkdir(parents=True)
    fmpy.extract(str(path), str(unpacked))
    library = library_in(unpacked, name)
    binaries = library.parent
    (unpacked / "told.c").write_text(as_c(library))
    shutil.rmtree(unpacked / "binaries")
    binaries.mkdir(parents=True)
    files = [str(unpacked / file) for file in sources(path)]
    subprocess.run([*compiler, *OPTIONS, *files, str(unpacked / "told.c"), "-o", str(library)], check=True)
    (unpacked / "told.c").unlink()
    with zipfile.ZipFile(folder / path.name, "w") as fmu:
        for file in sorted(unpacked.rglob("*")):
            if file.is_file():
                fmu.write(file, file.relative_to(unpacked))
    (folder / "lib").mkdir(exist_ok=True)
    shutil.copy(library, folder / "lib" / f"lib{name.lower()}{fmpy.sharedLibraryExtension}")
    shutil.rmtree(unpacked)
    return folder / path.name


def all_compiled(fmus, folder, **options):
    """All FMUs of a folder that have C; the others, such as plants, are copied. Gives the names of the former."""
    names = []
    for path in sorted(pathlib.Path(fmus).glob("*.fmu")):
        if sources(path):
            names.append(compiled(path, folder, **options).stem)
        else:
            shutil.copy(path, folder)
    return names


if __name__ == "__main__":
    print(*all_compiled(*sys.argv[1:]), sep="\n")
