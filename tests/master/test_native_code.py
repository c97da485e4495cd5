"""Machine code in two versions: both are there, and the processor chooses."""

from ctypes import CFUNCTYPE, POINTER, c_double, c_int32

import numpy as np
import pytest
from llvmlite import binding

from piston_cosim.fmu_ehd import blocks
from piston_cosim.master.fmi.native_code import TWICE, in_two_versions

MODULE = """
define internal i32 @"of.invert_in_place$x"(ptr noalias %a, double %by) #0 {
entry:
  %old = load double, ptr %a
  %new = fmul double %old, %by
  store double %new, ptr %a
  ret i32 7
}

define i32 @outside(ptr %a, double %by) {
  %status = call i32 @"of.invert_in_place$x"(ptr %a, double %by)
  ret i32 %status
}

attributes #0 = { nounwind }
"""


def test_the_kernels_that_are_there_twice_are_known():
    assert all(callable(getattr(blocks, name)) for name in TWICE)


@pytest.mark.parametrize("wide", [0, 1])
def test_one_of_two_versions_is_called(wide):
    text = in_two_versions(MODULE)
    assert text.count('"target-features"="+avx2"') == 1
    # what tells them apart here is a mark in the wide one
    begin = text.index('.wide"(')
    marked = text[:begin] + text[begin:].replace("ret i32 7", "ret i32 8", 1)
    marked = marked.replace("external hidden global i32", f"internal global i32 {wide}")
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    machine = binding.Target.from_default_triple().create_target_machine()
    module = binding.parse_assembly(marked)
    module.verify()
    with binding.create_mcjit_compiler(module, machine) as engine:
        engine.finalize_object()
        kind = CFUNCTYPE(c_int32, POINTER(c_double), c_double)
        numbers = np.array([3.0])
        place = numbers.ctypes.data_as(POINTER(c_double))
        assert kind(engine.get_function_address("outside"))(place, 0.1) == 7 + wide
        assert numbers[0] == 3.0 * 0.1


def test_a_module_without_such_kernels_stays_as_it_is():
    text = MODULE.replace("invert_in_place", "another")
    assert in_two_versions(text) == text
