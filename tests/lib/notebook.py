"""Executes a notebook by Jupyter's own kernel and prints what it has made as JSON: notebook.py FILE NAME...

NAMEs are variables of the notebook, DataFrames or Series. The output also has the media types of what each cell shows.
A cell that raises ends this with its traceback."""

import json
import sys

import nbformat
from nbclient import NotebookClient

file, names = sys.argv[1], sys.argv[2:]
book = nbformat.read(file, as_version=4)
nbformat.validate(book)
cells = len(book.cells)
asked = ", ".join(f'"{name}": json.loads({name}.to_json(orient="split", double_precision=15))' for name in names)
book.cells.append(nbformat.v4.new_code_cell(f"import json\nprint(json.dumps({{{asked}}}))"))
NotebookClient(book, timeout=120, kernel_name="python3").execute()

shown = [sorted({kind for output in cell.get("outputs", []) for kind in output.get("data", {})}) for cell in book.cells[:cells]]
text = "".join(output["text"] for output in book.cells[-1].outputs if output["output_type"] == "stream")
print(json.dumps({"shown": shown, "values": json.loads(text)}))
