"""What a source file needs of the project: what an FMU carries, and what a kernel's stamp reads."""

from textwrap import dedent

import pytest

from piston_cosim.master.fmi.tree import reached


@pytest.mark.parametrize(
    "text",
    [
        "from .wanted import a",
        "from . import wanted",
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


def test_a_source_is_parsed_once_for_all_processes(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))
    (tmp_path / "wanted.py").touch()
    files = [tmp_path / name for name in ("one.py", "same.py", "other.py")]
    for file, text in zip(files, ("from .wanted import a", "from .wanted import a", "import os")):
        file.write_text(text)
    assert reached(files[0].resolve()) == {files[0], tmp_path / "wanted.py"}
    monkeypatch.setattr("ast.parse", lambda source: pytest.fail("parsed again"))
    assert reached(files[1].resolve()) == {files[1], tmp_path / "wanted.py"}
    monkeypatch.undo()
    assert reached(files[2].resolve()) == {files[2]}


@pytest.mark.parametrize("harm", ["half of it", "a folder in its place", "no cache"])
def test_what_was_found_in_a_source_may_be_lost(tmp_path, monkeypatch, harm):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))
    (tmp_path / "wanted.py").touch()
    files = [tmp_path / name for name in ("one.py", "same.py")]
    for file in files:
        file.write_text(f"from .wanted import a  # {harm}")
    reached(files[0].resolve())
    for kept in (tmp_path / "cache" / "imports").iterdir():
        text = kept.read_text()
        kept.unlink()
        if harm == "half of it":
            kept.write_text(text[: len(text) // 2])
        elif harm == "a folder in its place":
            kept.mkdir()
    if harm == "no cache":
        monkeypatch.setenv("PISTON_COSIM_CACHE", str(files[0]))
    assert reached(files[1].resolve()) == {files[1], tmp_path / "wanted.py"}
