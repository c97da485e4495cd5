"""What of its code makes a kernel another one."""

import pytest

from piston_cosim.master.fmi.tree import code_digest

CODE = '''"""A module."""
import numpy  # of arrays


def double(x):
    """Return the double."""
    return 2 * x  # twice
'''


@pytest.mark.parametrize(
    "edited, same",
    [
        (("Return the double.", "Return 2 x.\n\n    Eq. (A1)"), True),
        (("# twice", "# the double"), True),
        (("import numpy", "\n\nimport numpy"), True),
        (("return 2 * x", "return 3 * x"), False),
        (("    return 2", '    "# x"\n    return 2'), False),
    ],
)
def test_the_digest_of_code_ignores_its_text(edited, same):
    one, other = CODE.encode(), CODE.replace(*edited).encode()
    assert (code_digest(one) == code_digest(other)) == same
