# SPDX-License-Identifier: BSD-3-Clause
"""The page of a model, in a notebook or as a file: the program mbsrank makes it."""
from __future__ import annotations

import csv
import html
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from .driver import Run
from .files import File, to_mjcf
from .model import Model


class Page:
    """A page of HTML that shows a model: a notebook displays it, `save` writes it."""

    def __init__(self, content: str, height: int = 480):
        self.html, self.height = content, height

    def save(self, path: str | os.PathLike) -> None:
        """Writes the page, which any browser opens without a network."""
        Path(path).write_text(self.html, encoding="utf-8")

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{html.escape(self.html)}" width="100%" height="{self.height}" '
                'style="border:0"></iframe>')

    def __repr__(self):
        return f"<Page, {len(self.html) / 1e6:.1f} MB>"


def _program() -> str:
    own = Path(__file__).with_name("bin") / "mbsrank"
    found = os.environ.get("MBSRANK_PROGRAM") or (str(own) if own.exists() else None) \
        or shutil.which("mbsrank")
    if found is None:
        raise FileNotFoundError("the program mbsrank is not on the path, and MBSRANK_PROGRAM "
                                "names none")
    return found


def _write_run(run: Run, file: File, to: Path) -> None:
    names = [one.name for one in file.joints if one.kind != "fixed"]
    with to.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["t", *names])
        for state in run:
            writer.writerow([repr(state.t), *map(repr, state.q.tolist())])


def view(model: Model | File | str | os.PathLike, run: Run | None = None,
         height: int = 480) -> Page:
    """The page of a model, a file that was read, or the path of one; with a run of a file whose
    joints have one axis each, moving as in it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.xml"
        if isinstance(model, Model):
            path.write_text(to_mjcf(model)[0], encoding="utf-8")
        elif isinstance(model, File):
            path.write_text(to_mjcf(model.model, model)[0], encoding="utf-8")
        else:
            path = Path(model)
        page = Path(folder) / "page.html"
        command = [_program(), "view", str(path), "-o", str(page)]
        if run is not None:
            if not isinstance(model, File):
                raise TypeError("a run is shown of a file that was read")
            _write_run(run, model, Path(folder) / "run.csv")
            command.insert(3, str(Path(folder) / "run.csv"))
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(done.stderr.strip() or f"mbsrank view failed ({done.returncode})")
        return Page(page.read_text(encoding="utf-8"), height)
