"""Machine code of a participant's entries for any processor that LLVM supports.

numba turns each entry and its callees into one LLVM module, simplified, but without anything
specific to this machine. LLVM then optimises and translates it for the target. The wrappers for
calls from Python are left out. There is no fast mathematics, as in `compiled`. It runs in a
separate process, because numba is configured only once.
"""

import gc
import gzip
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from .cache import write_whole
from .native_parts import symbol
from .tree import ROOT, import_part


class Target(NamedTuple):
    """Target of machine code: LLVM's name of the platform and of the oldest supported processor."""

    triple: str
    processor: str


TARGETS = {
    "linux64": Target("x86_64-unknown-linux-gnu", "x86-64"),
    "win64": Target("x86_64-w64-windows-gnu", "x86-64"),
    "aarch64-linux": Target("aarch64-unknown-linux-gnu", "generic"),
    "darwin64": Target("x86_64-apple-macosx11.0.0", "x86-64"),
    "aarch64-darwin": Target("arm64-apple-macosx11.0.0", "generic"),
}
"""Targets by name of the platform."""

RAW = {"NUMBA_OPT": "0", "NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
"""Settings for which numba's code is the same for all processors."""

OPTIMISATION = 3  # LLVM's level
AT_FIRST = 1  # before references are counted: enough to bring those of one kernel together


class Lengths(NamedTuple):
    """Positions of the lengths of an entry's arrays."""

    real: int = 0
    integer: int = 1
    memory: int = 2
    numbers: int = 3


LENGTHS = Lengths()

OPEN = {
    "memory": {"NRT_MemInfo_alloc_aligned", "NRT_MemInfo_call_dtor", "memcpy", "memset"},
    "shapes": {"numba_attempt_nocopy_reshape"},
    "products": {"native_dot", "native_times"},
    "participants": {"native_part"},
    "functions": {
        *("atan2", "ceil", "erf", "exp", "expm1", "floor", "hypot", "log10", "log1p", "pow"),
        *("sqrt", "tanh"),
    },
}
"""All symbols that machine code may use, by purpose: front/runtime.c, front/parts.c, libc and libm.
All others would need Python."""

PRODUCTS = {
    "declare i32 @numba_xxdot(i8, i8, i64, ptr, ptr, ptr)": """
define internal i32 @numba_xxdot(i8 %kind, i8 %conjugate, i64 %n, ptr %a, ptr %b, ptr %out) {
  call void @native_dot(i64 %n, ptr %a, ptr %b, ptr %out)
  ret i32 0
}
declare void @native_dot(i64, ptr, ptr, ptr)
""",
    "declare i32 @numba_xxgemv(i8, i8, i64, i64, ptr, ptr, i64, ptr, ptr, ptr)": """
define internal i32 @numba_xxgemv(i8 %kind, i8 %turned, i64 %m, i64 %n, ptr %alpha, ptr %a,
                                  i64 %lead, ptr %x, ptr %beta, ptr %y) {
  call void @native_times(i8 %turned, i64 %m, i64 %n, ptr %a, i64 %lead, ptr %x, ptr %y)
  ret i32 0
}
declare void @native_times(i8, i64, i64, ptr, i64, ptr, ptr)
""",
}
"""Dot and matrix-vector products. numba uses BLAS, and Python if that fails. Those of
front/runtime.c never fail, and LLVM sees that here."""


COUNTERS = ("NRT_incref", "NRT_decref")
COUNTING = """
define void @NRT_incref(ptr %counted) {
  %none = icmp eq ptr %counted, null
  br i1 %none, label %done, label %counts
counts:
  %before = load i64, ptr %counted
  %after = add i64 %before, 1
  store i64 %after, ptr %counted
  br label %done
done:
  ret void
}
define void @NRT_decref(ptr %counted) {
  %none = icmp eq ptr %counted, null
  br i1 %none, label %done, label %counts
counts:
  %before = load i64, ptr %counted
  %after = sub i64 %before, 1
  store i64 %after, ptr %counted
  %last = icmp eq i64 %after, 0
  br i1 %last, label %free, label %done
free:
  call void @NRT_MemInfo_call_dtor(ptr %counted)
  br label %done
done:
  ret void
}
declare void @NRT_MemInfo_call_dtor(ptr)
"""
"""Reference counting of a block of memory, `Counted` of front/runtime.c. numba counts atomically
and forbids inlining. Here only one thread uses the blocks of an instance."""

WIDE = "+avx2"
"""Processor feature of the second version of `TWICE`: vectors of four numbers."""
TWICE = ("invert_in_place", "substitute", "read", "read_both", "spread", "add_shell_pushes")
"""Kernels with two versions in a library for x86-64: the most expensive loops. Both give the
same bits, because no multiplication is fused with an addition."""


REPORT_INTERVAL = 3.0
"""Time between two messages about the progress [s]."""
KERNEL_COUNT = 450
"""Number of functions that numba compiles for the largest package, `fmu_mfbd`: 447."""


def object_files(
    package: str,
    platforms: Sequence[str],
    module_path: Path,
    progress: Callable[[str], object] = lambda text: None,
) -> dict[str, bytes]:
    """Return the object file of a participant's entries for each of the platforms.

    Parameters
    ----------
    package : str
        Part of the project with a module `native`, or importable package.
    platforms : list of str
        Keys of `TARGETS`.
    module_path : Path
        Cached LLVM module, compressed; created if missing. It takes minutes and is the same for
        all targets.
    progress : callable, optional
        Called with a message every `REPORT_INTERVAL` s.

    Raises
    ------
    RuntimeError
        With the message of numba or LLVM.
    """
    with tempfile.TemporaryDirectory() as scratch:
        command = [
            sys.executable,
            "-P",
            "-m",
            __name__,
            package,
            str(module_path),
            scratch,
            *platforms,
        ]
        around = Path(sys.modules[ROOT].__path__[0]).parent
        # last: files next to a checkout must not hide modules of the same name
        path = os.pathsep.join([*filter(None, sys.path), str(around)])
        environment = os.environ | RAW | {"PYTHONPATH": path}
        errors = Path(scratch, "errors")
        pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        with (
            errors.open("w") as stderr,
            subprocess.Popen(command, stderr=stderr, env=environment, **pipes) as process,
        ):
            for line in process.stdout or ():
                progress(line.rstrip())
        if process.returncode:
            text = errors.read_text()
            raise RuntimeError(f"{package} could not be compiled for a native FMU:\n{text}")
        return {name: (Path(scratch) / f"{name}.o").read_bytes() for name in platforms}


def _binding() -> Any:
    """Return llvmlite's module of LLVM, which only the compiling process imports."""
    return import_module("llvmlite.binding")


def module_text(package: str, part: Any) -> str:
    """Return the LLVM module of a package's entries; all other symbols are internal."""
    import numba
    from numba import types
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.registry import cpu_target

    from .callees import CalleeCompiler, EntryLibrary

    binding = _binding()
    compiler: Any = import_module("numba.core.compiler")
    carray = numba.__dict__["carray"]
    numbers = types.CPointer(types.float64)
    counts = types.CPointer(types.int64)
    flags = compiler.Flags()
    flags.nrt = True
    flags.no_cpython_wrapper = True
    flags.no_cfunc_wrapper = True
    flags.error_model = "numpy"
    whole = None
    names: list[str] = []
    for entry in part.entries:
        run = entry.callee

        def call(real: Any, integer: Any, memory: Any, numbers: Any, lengths: Any) -> None:
            n = carray(lengths, len(LENGTHS))
            run(  # noqa: B023 - compiled before the next one comes
                carray(real, n[LENGTHS.real]),
                carray(integer, n[LENGTHS.integer]),
                carray(memory, n[LENGTHS.memory]),
                carray(numbers, n[LENGTHS.numbers]),
            )

        with global_compiler_lock:
            compiled = compiler.compile_extra(
                cpu_target.typing_context,
                cpu_target.target_context,
                call,
                (numbers, counts, numbers, numbers, counts),
                types.void,
                flags,
                {},
                pipeline_class=CalleeCompiler,
            )
        EntryLibrary.link_callees(compiled.library)
        module = binding.parse_assembly(str(compiled.library._final_module))
        name = symbol(package, entry.py_func.__name__)
        module.get_function(compiled.fndesc.llvm_func_name).name = name
        names.append(name)
        if whole is None:
            whole = module
        else:
            whole.link_in(module)
    assert whole is not None
    text = str(whole)
    for declared, defined in PRODUCTS.items():
        text = re.sub(rf"^{re.escape(declared)}.*$", defined, text, flags=re.MULTILINE)
    whole = binding.parse_assembly(text)
    for one in (*whole.functions, *whole.global_variables):
        if not one.is_declaration:
            one.linkage = "external" if one.name in names else "internal"
    return str(whole)


def in_two_versions(text: str) -> str:
    """Return a module with two versions of each kernel of `TWICE`: any x86-64, and `WIDE`.

    The variable `native_wide` of front/runtime.c chooses between them.
    """
    pattern = re.compile(
        rf"^define internal i32 @(?P<name>\S*\d(?:{'|'.join(TWICE)})B\S*?)\((?P<given>.*)\)"
        r"(?P<rest>[^()\n]*)\{\n(?P<body>(?:.*\n)*?)\}$",
        re.MULTILINE,
    )
    text, count = pattern.subn(_twice, text)
    return f"{text}\n@native_wide = external hidden global i32\n" if count else text


def _twice(match: re.Match[str]) -> str:
    """Return both versions of a function, and a function of its name that chooses."""
    name, arguments, rest, body = match.group("name", "given", "rest", "body")
    names = {one: _renamed(name, one) for one in ("narrow", "wide")}
    types = [one.split()[0] for one in arguments.split(", ")]
    handed = ", ".join(f"{kind} %{k}" for k, kind in enumerate(types))
    own = {"narrow": "noinline", "wide": f'noinline "target-features"="{WIDE}"'}
    versions = [
        f"define internal i32 @{names[one]}({arguments}){rest} {own[one]} {{\n{body}}}"
        for one in names
    ]
    return "\n".join(
        [
            *versions,
            f"define internal i32 @{name}({handed}) {{",
            "  %wide = load i32, ptr @native_wide",
            "  %is_wide = icmp ne i32 %wide, 0",
            "  br i1 %is_wide, label %by_wide, label %by_narrow",
            *(
                f"by_{one}:\n  %of_{one} = call i32 @{names[one]}({handed})\n  ret i32 %of_{one}"
                for one in names
            ),
            "}",
        ]
    )


def _renamed(name: str, one: str) -> str:
    """Append an ending to an LLVM name, which may be quoted."""
    return f'{name[:-1]}.{one}"' if name.endswith('"') else f"{name}.{one}"


def translated(text: str, target: Target) -> bytes:
    """Return the object file of a module, which may use the symbols of `OPEN`."""
    binding = _binding()
    machine = _machine(target)
    x86 = target.triple.startswith("x86_64")
    text = without_counting(text)
    module = _parsed(in_two_versions(text) if x86 else text, target)
    _optimise(module, machine, AT_FIRST)
    pruning = binding.create_new_module_pass_manager()
    pruning.add_refprune_pass()  # removes pairs of increment and decrement within a kernel
    pruning.run(module, binding.create_pass_builder(machine, _level(AT_FIRST)))
    if any(f.name in COUNTERS for f in module.functions):
        module.link_in(_parsed(COUNTING, target))
        for name in COUNTERS:
            module.get_function(name).linkage = "internal"
    _optimise(module, machine, OPTIMISATION)
    strangers = sorted(open_symbols(module).difference(*OPEN.values()))
    if strangers:
        raise RuntimeError(f"machine code would call {', '.join(strangers)}, which are not there")
    return machine.emit_object(module)


def without_counting(text: str) -> str:
    """Return a module that only declares the functions that count references."""
    for name in COUNTERS:
        whole = rf"^define internal void @{name}\(.*\{{\n(?:.*\n)*?\}}$"
        text = re.sub(whole, f"declare void @{name}(ptr)", text, flags=re.MULTILINE)
    return text


def _parsed(text: str, target: Target) -> Any:
    """Return the parsed module for a target."""
    binding = _binding()
    module = binding.parse_assembly(text)
    module.triple = target.triple
    module.data_layout = str(_machine(target).target_data)
    return module


def _level(level: int) -> Any:
    """Return LLVM's options for an optimisation level."""
    binding = _binding()
    return binding.create_pipeline_tuning_options(speed_level=level)


def _optimise(module: Any, machine: Any, level: int) -> None:
    """Run LLVM's passes of an optimisation level."""
    binding = _binding()
    builder = binding.create_pass_builder(machine, _level(level))
    builder.getModulePassManager().run(module, builder)


def open_symbols(module: Any) -> set[str]:
    """Return the names of functions that a module uses but does not define, without LLVM's own."""
    named = {f.name for f in module.functions if f.is_declaration}
    return {name for name in named if not name.startswith("llvm.")}


@cache
def _machine(target: Target) -> Any:
    binding = _binding()
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    return binding.Target.from_triple(target.triple).create_target_machine(
        cpu=target.processor, opt=OPTIMISATION, reloc="pic", codemodel="default"
    )


def main(package: str, module_path: str, folder: str, *platforms: str) -> None:
    """Write the object files into a folder, and save the LLVM module at `module_path`."""
    threading.Thread(target=_follow, daemon=True).start()
    phase = [f"compiling {package}"]
    threading.Thread(target=_report, args=(phase,), daemon=True).start()
    gc.disable()  # numba creates millions of small objects, which live until the process ends
    part = import_part(f"{package}.native").PART
    if os.path.exists(module_path):
        text = gzip.decompress(Path(module_path).read_bytes()).decode()
    else:
        text = module_text(package, part)
        write_whole(Path(module_path), gzip.compress(text.encode(), 1))
    for name in platforms:
        phase[0] = f"optimising {package} for {name}"
        Path(folder, f"{name}.o").write_bytes(translated(text, TARGETS[name]))


def _follow() -> None:
    """End this process when its parent process has ended."""
    sys.stdin.read()
    os._exit(1)


def _report(phase: list[str]) -> None:
    """Print phase, time and share of compiled kernels every `REPORT_INTERVAL` s."""
    event: Any = import_module("numba.core.event")
    begin = time.monotonic()
    listener = event.RecordingListener()
    event.register("numba:compile", listener)
    while True:
        time.sleep(REPORT_INTERVAL)
        share = min(99, 100 * sum(one.is_end for _, one in listener.buffer) // KERNEL_COUNT)
        seconds = time.monotonic() - begin
        at = f"{share} %, " if phase[0].startswith("compiling") else ""
        print(f"{phase[0]}: {at}{seconds:.0f} s", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
