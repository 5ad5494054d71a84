"""The whole trace is passed to other libraries by Arrow's PyCapsule protocol."""

import numpy as np
import pytest


def same(run, column):
    np.testing.assert_array_equal(np.asarray(column), run.trace["truth_y_m"])


def test_pyarrow_takes_it_and_its_file_says_the_same(lateral_run, tmp_path):
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    table = pa.table(lateral_run.to_arrow())
    assert table.column_names == lateral_run.trace.columns
    same(lateral_run, table["truth_y_m"])
    assert table["desired_x_m"].null_count == table.num_rows
    lateral_run.write(tmp_path)
    stored = pq.read_table(tmp_path / "trace.parquet")
    assert stored.schema.names == table.schema.names and stored.schema.types == table.schema.types
    assert stored.equals(table.cast(stored.schema))


def test_polars_takes_it(lateral_run):
    pl = pytest.importorskip("polars")
    same(lateral_run, pl.DataFrame(lateral_run.to_arrow())["truth_y_m"])
    same(lateral_run, pl.DataFrame(lateral_run.trace)["truth_y_m"])


def test_pandas_takes_it(lateral_run):
    pd = pytest.importorskip("pandas")
    if not hasattr(pd.DataFrame, "from_arrow"):
        pytest.skip("pandas before 3")
    same(lateral_run, pd.DataFrame.from_arrow(lateral_run.to_arrow())["truth_y_m"])


def test_pandas_takes_the_trace_itself(lateral_run):
    pd = pytest.importorskip("pandas")
    frame = pd.DataFrame(lateral_run.trace)
    assert list(frame.columns) == lateral_run.trace.columns and len(frame) == lateral_run.trace.rows
    same(lateral_run, frame["truth_y_m"])
    assert frame.equals(lateral_run.to_pandas())


def test_what_was_recorded_is_not_changed_but_copied(lateral_run):
    trace = lateral_run.trace
    for change in (lambda: trace.pop("t_s"), lambda: trace.setdefault("t_s", 1), lambda: trace.update(t_s=1), trace.clear):
        with pytest.raises(TypeError, match="cannot be changed"):
            change()
    with pytest.raises(TypeError, match="cannot be changed"):
        trace["t_s"] = 1
    assert trace == trace
    copy = dict(trace)
    copy["mine"] = copy.pop("t_s")
    assert (copy["mine"] == trace["t_s"]).all()


def test_duckdb_takes_it(lateral_run):
    duckdb = pytest.importorskip("duckdb")
    recorded = lateral_run.to_arrow()  # noqa: F841, the query names it
    rows = duckdb.sql("select count(*), max(truth_y_m) from recorded").fetchall()
    assert rows[0] == (lateral_run.trace.rows, lateral_run.trace["truth_y_m"].max())
