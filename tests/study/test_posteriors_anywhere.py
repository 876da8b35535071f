"""Posteriors of a study, wherever they are computed: in this process, in processes of their own, on a Dask cluster."""

from concurrent.futures import ThreadPoolExecutor

import pytest
import xarray as xr
from small_study import SETTINGS

from vasowave.study.results import read_results
from vasowave.study.running import read_study, run_study


def drawn(folder, **where):
    """Return the draws and the evidence of every animal after the study ran somewhere."""
    run_study(read_study(folder), **where)
    results = read_results(folder)
    return {name: results[name].laws["linear"].posterior for name in results}


@pytest.mark.validation
def test_draws_are_the_same_alone_in_processes_and_on_a_dask_cluster(make_study):
    from distributed import LocalCluster

    settings = SETTINGS + "inference: posterior\n"
    folders = [make_study(name, 1, settings) for name in ("alone", "processes", "cluster")]
    with ThreadPoolExecutor(1) as thread:
        alone = drawn(folders[0], executor=thread)
    processes = drawn(folders[1], workers=2)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:
        distributed = drawn(folders[2], scheduler=cluster.scheduler_address)
    here = alone["mouse 0"]
    for there in (processes["mouse 0"], distributed["mouse 0"]):
        xr.testing.assert_identical(there.groups["posterior"], here.groups["posterior"])
        # weights come of the emulator's sums, which linear algebra with other threads rounds otherwise
        xr.testing.assert_allclose(there.table, here.table, rtol=1e-3, atol=1e-6)
