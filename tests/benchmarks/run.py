"""``make bench``: every bench_*.py of this folder, as ratios within one run."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path


def main() -> None:
    """Print one table for each benchmark; names on the command line choose."""
    chosen = sys.argv[1:]
    for path in sorted(Path(__file__).parent.glob("bench_*.py")):
        if chosen and path.stem.removeprefix("bench_") not in chosen:
            continue
        spec = importlib.util.spec_from_file_location(path.stem, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        print(f"\n{(module.__doc__ or '').splitlines()[0]}", flush=True)
        rows = module.main()
        widths = [max(len(row[i]) for row in rows) for i in range(3)]
        for what, measured, asked in rows:
            print(f"  {what:{widths[0]}}  {measured:>{widths[1]}}  {asked}", flush=True)


if __name__ == "__main__":
    main()
