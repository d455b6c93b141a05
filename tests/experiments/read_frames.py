"""read_frames.py OUT: trajectory.npy equals trajectory.csv, the vtu frames equal states.csv."""
import csv
import sys
import xml.etree.ElementTree
from pathlib import Path

import meshio
import numpy

out = Path(sys.argv[1])
with open(out / "trajectory.csv", newline="") as file:
    lines = list(csv.reader(file))
table = numpy.array([[float(cell) for cell in line] for line in lines[1:]])
array = numpy.load(out / "trajectory.npy", allow_pickle=False)
assert array.dtype == numpy.float64 and array.flags.c_contiguous and array.shape == (5, len(lines[0])), array.shape
assert array.tobytes() == table.tobytes(), "trajectory.npy is not trajectory.csv"

with open(out / "states.csv", newline="") as file:
    states = list(csv.DictReader(file))
sets = xml.etree.ElementTree.parse(next(out.glob("*.pvd"))).getroot().findall("Collection/DataSet")
assert len(sets) == 5
nodes = len(states) // 5
for frame, entry in enumerate(sets):
    mesh = meshio.read(out / entry.attrib["file"])
    assert mesh.field_data["TimeValue"][0] == array[frame, 0] == float(entry.attrib["timestep"])
    for i, state in enumerate(states[nodes * frame : nodes * (frame + 1)]):
        for c, axis in enumerate("xyz"):
            assert mesh.points[i, c] == float(state[axis]), (frame, state["name"])
            assert mesh.point_data["velocity"][i, c] == float(state["v" + axis]), (frame, state["name"])
    kinds = {}
    for block, kind, force, strain in zip(mesh.cells, *(mesh.cell_data[k] for k in ("kind", "row_force", "strain"))):
        assert numpy.isfinite(strain).all()
        unknown = frame == 0 and block.type == "line"  # before the first step
        assert (numpy.isnan(force) if unknown else numpy.isfinite(force)).all()
        kinds.setdefault(block.type, set()).update(kind.ravel().tolist())
    assert kinds == {"vertex": {0}, "line": {1}, "triangle": {2}}, kinds
print(f"{len(sets)} frames, {array.shape[1]} columns, {len(mesh.points)} points")
