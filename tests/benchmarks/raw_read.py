"""Read a STEP file as any CAD program must, and nothing else: the peer of the commands in `bench_assemblies`.

`python tests/benchmarks/raw_read.py FILE` imports the kernel's reader of assemblies (XCAF), with names, colours and
layers, parses the file and transfers it. It has no part of this project in it.
"""

import os
import sys

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDocStd import TDocStd_Document

document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
reader = STEPCAFControl_Reader()
reader.SetNameMode(True)
reader.SetColorMode(True)
reader.SetLayerMode(True)
is_read = reader.ReadFile(sys.argv[1]) == IFSelect_ReturnStatus.IFSelect_RetDone and reader.Transfer(document)
os._exit(0 if is_read else 1)  # freeing the document takes a second more at 17 000 faces
