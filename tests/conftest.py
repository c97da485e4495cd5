"""One BLAS thread, as the command line has it: rounding does not depend on the machine's cores, and
small algebra is faster.
"""

import os

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
