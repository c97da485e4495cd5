"""The lowest version of each dependency that pyproject.toml admits, as constraints for pip."""

import tomllib
from pathlib import Path

project = tomllib.loads(Path("pyproject.toml").read_text())["project"]
for wanted in project["dependencies"]:
    print(wanted.replace(">=", "=="))
