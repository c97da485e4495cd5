"""Cases and data: a folder for each case with case.toml, README.md, meshes and scripts."""

from pathlib import Path

MODELS = Path(__file__).parent
