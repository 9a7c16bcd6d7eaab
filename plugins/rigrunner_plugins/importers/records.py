"""The importers that ship with Rigrunner."""

from __future__ import annotations

from rigrunner.api import Imported, ImporterExample, ImporterRecord, hookimpl

TABLE = ImporterExample(
    source="four numbers below their names, RFC 4180",
    content=b"angle,torque\r\n0.25,1.5\r\n-0.25,-2\r\n",
    suffix=".csv",
    columns={"tester.angle": "angle", "tester.torque": 2},
    values={"tester.angle": (0.25, -0.25), "tester.torque": (1.5, -2.0)},
)


@hookimpl
def rigrunner_importers() -> list[ImporterRecord]:
    """Return the readers of CSV, HDF5, LVM, MATLAB and TDMS files."""
    return [
        ImporterRecord(
            name="csv",
            help="Text in columns, one recording per file",
            settings="rigrunner_plugins.importers.settings:TableSettings",
            factory=Imported("rigrunner_plugins.importers.csv_file:CsvImporter"),
            examples=(TABLE,),
        ),
        ImporterRecord(
            name="hdf5",
            help="HDF5: a group of datasets is a recording",
            factory=Imported("rigrunner_plugins.importers.hdf5_file:Hdf5Importer"),
        ),
        ImporterRecord(
            name="lvm",
            help="LabVIEW measurement file (.lvm): a segment is a recording",
            settings="rigrunner_plugins.importers.settings:LvmSettings",
            factory=Imported("rigrunner_plugins.importers.lvm_file:LvmImporter"),
        ),
        ImporterRecord(
            name="matlab",
            help="MATLAB 5 to 7.3 (.mat): vectors, columns of a matrix, fields of structures",
            factory=Imported("rigrunner_plugins.importers.matlab_file:MatlabImporter"),
        ),
        ImporterRecord(
            name="tdms",
            help="LabVIEW TDMS: a group of channels is a recording",
            factory=Imported("rigrunner_plugins.importers.tdms_file:TdmsImporter"),
        ),
    ]
