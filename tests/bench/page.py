"""How fast the report's page opens and plays, in a Chromium that draws by software.

`python tests/bench/page.py [report.html ...]` prints the time to the first picture, frames a second
with the bodies before the eyes, and the processor time of a frame; of a made-up report of two runs
in 361 instants on a grid of 40 x 40 with bodies of the shipped ones' size, if none is given. Asked
are 2 s and 30 a second, and 5 MB. Of a machine that is otherwise quiet; beside other work the
processor time tells. A real page: `piston-cosim run numerical_example`, then `piston-cosim results
report`.
"""

import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.master.browser import Browser, first_picture, found, pace
from tests.master.test_page import large_page

FRAMES = 150
TIMES = 3

if not found():
    sys.exit("no chromium, no google-chrome")
with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
    pages = [Path(text) for text in sys.argv[1:]] or [large_page(Path(folder))]
    print(f"load {os.getloadavg()[0]:.1f}, {os.cpu_count()} processors")
    for page in pages:
        print(f"{page}: {page.stat().st_size / 1e6:.1f} MB")
        for k in range(TIMES):
            with Browser(Path(folder) / f"profile_{k}") as browser:
                browser.open(page)
                first = first_picture(browser)
                played = pace(browser, FRAMES)
            print(
                f"  first picture {first:.2f} s, {played.rate:.1f} frames a second; a frame takes "
                f"{played.page:.1f} ms of the page's thread, {played.graphics:.1f} of graphics, "
                f"{played.all:.1f} of all processes"
            )
