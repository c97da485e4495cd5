"""Cases and data: one folder a case (case.toml, README.md, meshes and the scripts that make
them).
"""

from pathlib import Path

MODELS = Path(__file__).parent
