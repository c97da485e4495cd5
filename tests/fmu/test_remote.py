"""Participants on workers of a Dask cluster, by TLS: the bits of a run in one process, and
sentences where a worker hangs, or where nobody is trusted. Two workers of this machine stand for
two others.
"""

import subprocess
import sys
from shutil import which

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import closing, start
from piston_cosim.master.coupling.stepping import Stepper
from piston_cosim.master.fmi.errors import BadInput, ParticipantFault
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

from .counter import case_text, library, make

__all__ = ["library"]

distributed = pytest.importorskip("dask.distributed")
LOOP = (("a.x", "b.u", ""), ("b.x", "a.u", "tolerance = 1e-12"))
TYPED = [("a.n", "b.number", ""), ("a.odd", "b.truth", ""), ("a.words", "b.heard", "")]
LAST = "".join(f'{name} = "last b.{name}"\n' for name in ("number_sum", "truth_sum"))


def certificate(folder, name):
    """A certificate that vouches for itself, with its key."""
    made = folder / f"{name}.crt"
    key = folder / f"{name}.key"
    words = (
        f"req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost -keyout {key} -out {made}"
    )
    subprocess.run(["openssl", *words.split()], check=True, capture_output=True)
    return made, key


def settings(trusted, own):
    """Dask's configuration of one who shows `own` and believes `trusted`."""
    tls = "distributed.comm.tls"
    shown = {
        f"{tls}.{role}.{what}": str(path)
        for role in ("client", "scheduler", "worker")
        for what, path in zip(("cert", "key"), own)
    }
    return {f"{tls}.ca-file": str(trusted[0]), **shown}


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Address of a scheduler with two workers, and their certificate."""
    import dask

    if not which("openssl"):
        pytest.skip("no openssl to make certificates")
    ours = certificate(tmp_path_factory.mktemp("keys"), "ours")
    with dask.config.set(settings(ours, ours)):
        with distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            protocol="tls://",
            host="127.0.0.1",
            security=distributed.Security(require_encryption=True),
            dashboard_address=None,
        ) as made:
            yield made, ours


@pytest.fixture
def trusting(cluster):
    import dask

    with dask.config.set(settings(cluster[1], cluster[1])):
        yield cluster[0].scheduler_address


@pytest.fixture
def folder(tmp_path, library):
    for name in "ab":
        make(tmp_path / f"{name}.fmu", library)
    return tmp_path


def case(folder, host, wires=(*LOOP, *TYPED), **more):
    text = case_text(wires, more=f"parallel = true\n[summary]\n{LAST}", **more)
    if host:
        for name in "ab":
            text = text.replace(f'"{name}.fmu"', f'"{name}.fmu"\nhost = "{host}"\ntimeout = "10 s"')
    path = folder / "case.toml"
    path.write_text(text)
    tree = read_tree(path)
    return check_case(tree, path), tree


def test_two_workers_give_the_bits_of_one_process(folder, trusting):
    found = []
    for host in (None, trusting):
        checked, tree = case(folder, host, a="k = 2.0")
        output = folder / f"{bool(host)}.h5"
        summary = run(open_system(checked, folder, print), checked, tree, output)
        results = Results(output)
        found.append([results.series(f"{name}.x").values.tobytes() for name in "ab"])
        assert summary["number_sum"] == sum(range(10)) and summary["truth_sum"] == 5
    assert found[0] == found[1]


def test_each_has_a_worker_of_its_own_and_both_step_at_once(folder, trusting):
    checked, _ = case(folder, trusting, a="k = 2.0")
    system = open_system(checked, folder, print)
    with closing(system.participants.values()):
        start(system)
        assert len({p._worker for p in system.participants.values()}) == 2
        stepper = Stepper(system, method_of(checked.coupling), 3)
        assert stepper.interface.apart == {"a", "b"}
        stepper.advance(0.0, 0.1)
        a, b = system.participants.values()
        saved = a.save()
        data = a.serialise(saved)
        before = a.get("x")
        a.step(0.1, 0.1)
        assert a.get("x") != before
        a.restore(a.deserialise(data))
        assert a.get("x") == before
        b.restore(b.save())
        b.step(0.1, 0.1)
        found = b.derivative({"u": np.array(1.0)}, ["x"])
        # x' = (x + H u) / (1 + H k), H = 0.1, k = 1; a difference, 1e-5 of round-off 1e-16
        assert found["x"] == pytest.approx(0.1 / 1.1, rel=1e-9)


def test_a_worker_that_goes_is_told(folder, trusting, cluster):
    checked, _ = case(folder, trusting, a="trouble = 1\ntrouble_at = 0")
    system = open_system(checked, folder, print)
    a = system.participants["a"]
    a.timeout = 5.0
    with pytest.raises(ParticipantFault, match="a: on tls://.*, step: no answer within 5 s"):
        try:
            start(system)
            a.step(0.0, 0.1)  # hangs
        finally:
            a.timeout = 1.0
            with pytest.raises(ParticipantFault):
                a.close()
            system.participants["b"].close()


def test_who_is_not_trusted_is_refused(folder, trusting, tmp_path):
    import dask

    other = certificate(tmp_path, "other")
    checked, _ = case(folder, trusting)
    with dask.config.set(settings(other, other)):
        system = open_system(checked, folder, print)
        with pytest.raises(BadInput, match="a: host = 'tls://"):
            start(system)


@pytest.mark.parametrize(
    "line, words",
    [
        ('host = "tcp://127.0.0.1:8786"', "host"),
        (
            'host = "tls://127.0.0.1:8786"\nisolated = true',
            "host: expected isolated = false with a host, got true",
        ),
    ],
)
def test_what_is_no_host_is_refused(folder, line, words):
    text = case_text(LOOP).replace('"a.fmu"', f'"a.fmu"\n{line}')
    (folder / "case.toml").write_text(text)
    with pytest.raises(BadInput, match=words):
        check_case(read_tree(folder / "case.toml"), folder / "case.toml")


def test_a_machine_without_dask_says_so(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "dask.distributed", None)
    checked, _ = case(folder, "tls://127.0.0.1:1")
    with pytest.raises(BadInput, match=r"a: host: install dask\[distributed\] first"):
        start(open_system(checked, folder, print))
