"""Machine code in two versions: both are there, and the processor chooses."""

import threading
from ctypes import CFUNCTYPE, POINTER, byref, c_double, c_int32, c_int64, c_void_p, cast

import numpy as np
import pytest
from llvmlite import binding

from piston_cosim.fmu_ehd.solvers import blocks
from piston_cosim.fmu_mfbd.geometry import modal_field, pin
from piston_cosim.master.fmi import builder_native
from piston_cosim.master.fmi.native_code import (
    COUNTERS,
    COUNTING,
    TWICE,
    in_two_versions,
    without_counting,
)

MODULE = """
define internal i32 @"_ZN6blocks15invert_in_placeB2v1B3c8$"(ptr noalias %a, double %by) #0 {
entry:
  %old = load double, ptr %a
  %new = fmul double %old, %by
  store double %new, ptr %a
  ret i32 7
}

define i32 @outside(ptr %a, double %by) {
  %status = call i32 @"_ZN6blocks15invert_in_placeB2v1B3c8$"(ptr %a, double %by)
  ret i32 %status
}

attributes #0 = { nounwind }
"""


def engine(text, *others):
    """Return an engine with the machine code of a module that is linked with others."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    module = binding.parse_assembly(text)
    for other in others:
        module.link_in(binding.parse_assembly(other))
    module.verify()
    machine = binding.Target.from_default_triple().create_target_machine()
    made = binding.create_mcjit_compiler(module, machine)
    made.finalize_object()
    return made


def test_the_kernels_that_are_there_twice_are_known():
    modules = blocks, modal_field, pin
    assert all(any(hasattr(one, name) for one in modules) for name in TWICE)


@pytest.mark.parametrize("wide", [0, 1])
def test_one_of_two_versions_is_called(wide):
    text = in_two_versions(MODULE)
    assert text.count('"target-features"="+avx2"') == 1
    # what tells them apart here is a mark in the wide one
    begin = text.index('.wide"(')
    marked = text[:begin] + text[begin:].replace("ret i32 7", "ret i32 8", 1)
    marked = marked.replace("external hidden global i32", f"internal global i32 {wide}")
    with engine(marked) as made:
        kind = CFUNCTYPE(c_int32, POINTER(c_double), c_double)
        numbers = np.array([3.0])
        place = numbers.ctypes.data_as(POINTER(c_double))
        assert kind(made.get_function_address("outside"))(place, 0.1) == 7 + wide
        assert numbers[0] == 3.0 * 0.1


def test_a_module_without_such_kernels_stays_as_it_is():
    for other in ("another", "invert_in_place_again"):
        text = MODULE.replace("invert_in_place", other)
        assert in_two_versions(text) == text


MEMORY = """
define internal void @NRT_incref(ptr %old) #0 {
begin:
  ret void
}

define internal void @NRT_decref(ptr %old) #0 {
begin:
  ret void
}

define void @outside(ptr %counted) {
  call void @NRT_incref(ptr %counted)
  call void @NRT_decref(ptr %counted)
  call void @NRT_decref(ptr %counted)
  ret void
}

attributes #0 = { noinline }
"""


def test_references_are_counted_and_the_last_one_frees():
    """With 1 and 2 at the beginning; none of a block that is nowhere."""
    text = without_counting(MEMORY)
    assert all(f"declare void @{name}(ptr)" in text for name in COUNTERS)
    assert "begin:" not in text
    freed = []
    free = CFUNCTYPE(None, POINTER(c_int64))(lambda at: freed.append(at.contents.value))
    binding.add_symbol("NRT_MemInfo_call_dtor", cast(free, c_void_p).value)
    with engine(text, COUNTING) as made:
        run = CFUNCTYPE(None, POINTER(c_int64))(made.get_function_address("outside"))
        for count, left, of_freed in ((2, 1, []), (1, 0, [0])):
            block = c_int64(count)
            run(byref(block))
            assert (block.value, freed) == (left, of_freed)
        run(None)
        assert freed == [0]


def test_packages_are_compiled_side_by_side(monkeypatch):
    """Either one waits until the other has begun."""
    both = threading.Barrier(2)

    def compiled(package, platforms, progress):
        both.wait(30)
        return {platforms[0]: package.encode()}

    monkeypatch.setattr(builder_native, "object_files", compiled)
    monkeypatch.setenv("PISTON_COSIM_JOBS", "2")
    made = builder_native.compiled_packages(["film", "bodies"], ["linux64"], print)
    assert made == {"film": {"linux64": b"film"}, "bodies": {"linux64": b"bodies"}}
