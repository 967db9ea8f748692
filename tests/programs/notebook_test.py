"""notebook_test.py NOTEBOOK: its cells run as they are, at most 15 lines of them are code, and its paint hides the car."""
import json
import sys

notebook = json.load(open(sys.argv[1]))
cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
assert sum(bool(line.strip()) for cell in cells for line in cell.splitlines()) <= 15
assert not any(cell.get("outputs") for cell in notebook["cells"])
scope = {}
for cell in cells:
    exec(cell, scope)
found = scope["found"]
assert found["own"] == 40 and found["shuffled"] >= 36 and found["camouflage"] <= 16, found
