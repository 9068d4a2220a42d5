#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the cells of a notebook in its folder, as Jupyter would, without Jupyter: what a cell's last expression
is, as text or SVG, has to be the output that the notebook has. The service is DRAPED_URL.

usage: notebook.py NOTEBOOK [--write]    --write: keeps what the cells say as the notebook's outputs
"""
import ast
import contextlib
import io
import json
import os
import re
import sys


def shown(value):
    """As Jupyter shows the value of a cell."""
    data = {"text/plain": repr(value).splitlines(keepends=True)}
    if hasattr(value, "_repr_svg_"):
        data = {"image/svg+xml": re.sub(r"\b[0-9a-f]{32}\b", "ID", value._repr_svg_()).splitlines(keepends=True),
                "text/plain": [f"<{type(value).__name__}>"]}
    return data


def run(source, names, count):
    """The outputs of a cell."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    value, said = None, io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(tree, f"cell {count}", "exec"), names)
        if last:
            value = eval(compile(ast.Expression(last.value), f"cell {count}", "eval"), names)
    outputs = []
    if said.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": said.getvalue().splitlines(keepends=True)})
    if value is not None:
        outputs.append({"data": shown(value), "execution_count": count, "metadata": {},
                        "output_type": "execute_result"})
    return outputs


def main(path, write=False):
    with open(path, encoding="utf-8") as file:
        book = json.load(file)
    os.chdir(os.path.dirname(path))
    sys.path.insert(0, "")
    names, other = {"__name__": "__main__"}, 0
    cells = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    for count, cell in enumerate(cells, 1):
        outputs = run("".join(cell["source"]), names, count)
        if not write and outputs != cell["outputs"]:
            other += 1
            print(f"cell {count} says\n{json.dumps(outputs)[:2000]}\nand not\n{json.dumps(cell['outputs'])[:2000]}")
        cell.update(outputs=outputs, execution_count=count)
    if write:
        with open(os.path.basename(path), "w", encoding="utf-8") as file:
            file.write(json.dumps(book, indent=1, ensure_ascii=False) + "\n")
    print(f"{len(cells)} cells, {other} with another output")
    return 1 if other or not cells else 0


if __name__ == "__main__":
    sys.exit(main(os.path.abspath(sys.argv[1]), "--write" in sys.argv))
