"""Files of a LeRobot data set's folder, each of which takes the place of another one at once."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any


def read_tasks(file: Path) -> list[str]:
    """Return the tasks of a table in the order of their numbers.

    Raises:
        OSError: The file cannot be read.
        ValueError: The table is broken.
    """
    from pyarrow import parquet

    rows = parquet.read_table(file).to_pylist()
    rows.sort(key=lambda row: int(row["task_index"]))
    return [str(next(v for k, v in row.items() if k != "task_index")) for row in rows]


def write_tasks(file: Path, tasks: Sequence[str]) -> None:
    """Write the table of tasks, whose index pandas makes of a column that metadata names."""
    import pyarrow as pa

    column = "__index_level_0__"
    kinds = {"task_index": "int64", column: "unicode"}
    pandas = {
        "index_columns": [column],
        "column_indexes": [],
        "columns": [
            {
                "name": None if name == column else name,
                "field_name": name,
                "pandas_type": kind,
                "numpy_type": "object" if kind == "unicode" else kind,
                "metadata": None,
            }
            for name, kind in kinds.items()
        ],
    }
    table = pa.table({"task_index": list(range(len(tasks))), column: list(tasks)})
    write_table(file, table.replace_schema_metadata({"pandas": json.dumps(pandas)}))


# Any: pyarrow's table.
def write_table(file: Path, table: Any) -> None:
    """Write a table in place of another one, complete on the disk.

    Raises:
        OSError: The file cannot be written.
    """
    from pyarrow import parquet

    draft = _draft(file)
    parquet.write_table(table, draft)
    _put(draft, file)


def write_json(file: Path, document: object) -> None:
    """Write a JSON document in place of another one, complete on the disk.

    Raises:
        OSError: The file cannot be written.
    """
    draft = _draft(file)
    draft.write_text(json.dumps(document, indent=4, ensure_ascii=False), encoding="utf-8")
    _put(draft, file)


def _draft(file: Path) -> Path:
    """Return the path at which a file is written before it takes the place of another."""
    file.parent.mkdir(parents=True, exist_ok=True)
    return file.with_name(f".{file.name}.draft")


def _put(draft: Path, file: Path) -> None:
    """Put a written file into its place, complete on the disk."""
    with draft.open("rb") as written:
        os.fsync(written.fileno())
    draft.replace(file)
