# SPDX-License-Identifier: Apache-2.0
"""Reads the XDMF side-car in the two readers of ParaView that know its slabs:
pvpython paraview_read.py FOLDER…"""
import os
import sys

import paraview
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from truth import Comparison, load  # noqa: E402



def leaves(data):
    """Grids that hold points, in their order, out of blocks of blocks."""
    if hasattr(data, "GetPoints"):
        return [data]
    for kind in ("PartitionedDataSet", "Partition", "Piece", "Block"):
        count = getattr(data, f"GetNumberOf{kind}s", None)
        if count:
            get = getattr(data, f"Get{kind}")
            return [leaf for i in range(count()) for leaf in leaves(get(i))]
    raise TypeError(type(data))


good = True
for folder, name in [(f, n) for f in sys.argv[1:] for n in ("Xdmf3ReaderS", "Xdmf3ReaderT")]:
    truth = load(folder)
    version = paraview.__version__ if hasattr(paraview, "__version__") else ""
    result = Comparison(f"ParaView {version}, {name}", f"{folder}/all.xdmf", 0.0)
    reader = getattr(simple, name)(FileName=[f"{folder}/all.xdmf"])
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues)
    result.same("times", times, [frame / truth["fps"] for frame in truth["frames"]])
    for i, time in enumerate(times):
        reader.UpdatePipeline(time)
        data = servermanager.Fetch(reader)
        for block, mesh in zip(leaves(data), truth["meshes"], strict=True):
            place = f"{mesh['name']}, time {time}"
            result.add(place, vtk_to_numpy(block.GetPoints().GetData()), mesh["positions"][i])
            cells = vtk_to_numpy(block.GetCells().GetConnectivityArray()).reshape(-1, 3)
            result.same(place + ", triangles", cells, mesh["triangles"])
    good &= result.tell()
sys.stdout.flush()
os._exit(0 if good else 1)
