"""The lowest version of each dependency that pyproject.toml admits, as constraints for pip."""

import re
import sys
import tomllib
from pathlib import Path

project = tomllib.loads(Path("pyproject.toml").read_text())["project"]
wanted = project["dependencies"]
sys.stdout.writelines(re.sub(r"\[.*?\]|>=", lambda m: "==" * (m[0] == ">="), line) + "\n" for line in wanted)
