"""What a source file needs of the project: what an FMU carries, and what a kernel's stamp reads."""

from textwrap import dedent

import pytest

from piston_cosim.master.fmi.tree import reached


@pytest.mark.parametrize(
    "text",
    [
        "from .wanted import a",
        "from . import wanted",
        "from .wanted import (\n    a,  # (so)\n    b,\n)",
        "x = 1; from .wanted import a",
        "if x: from .wanted import a",
        """
        try:
            import elsewhere
        except ImportError:
            from .wanted import a
        """,
        """
        try:
            pass
        finally:
            from .wanted import a
        """,
        """
        for _ in x:
            pass
        else:
            from .wanted import a
        """,
        """
        class A:
            def f(self):
                with x:
                    from .wanted import a
        """,
        """
        match x:
            case 1:
                from .wanted import a
        """,
        """
        async def f():
            while x:
                from .wanted import a
        """,
        "from .between import a",
    ],
)
def test_an_import_is_found_wherever_it_stands(tmp_path, text):
    (tmp_path / "wanted.py").touch()
    (tmp_path / "other.py").touch()
    (tmp_path / "between.py").write_text("from .wanted import a")
    file = tmp_path / "file.py"
    file.write_text(dedent(text))
    found = reached(file.resolve())
    assert file in found
    assert tmp_path / "wanted.py" in found
    assert tmp_path / "other.py" not in found


def test_what_is_written_about_an_import_is_none(tmp_path):
    (tmp_path / "wanted.py").touch()
    file = tmp_path / "file.py"
    file.write_text('"""As in\n\nfrom .wanted import a\n"""\n# from .wanted import a\n')
    assert reached(file.resolve()) == {file}
