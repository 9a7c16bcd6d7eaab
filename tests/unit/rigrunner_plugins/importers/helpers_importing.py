"""Files as other programs write them."""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from scipy.io import savemat

from rigrunner.runfile import read_info

LVM_HEADER = """\
LabVIEW Measurement{sep}
Writer_Version{sep}2
Reader_Version{sep}2
Separator{sep}{name}
Decimal_Separator{sep}{mark}
Multi_Headings{sep}{many}
X_Columns{sep}{x}
Time_Pref{sep}Absolute
Operator{sep}user
Date{sep}2026/03/02
Time{sep}10:15:00{mark}5
***End_of_Header***{sep}
"""
LVM_SEPARATORS = {"\t": "Tab", ",": "Comma"}


def lvm_text(
    segments,
    *,
    x="One",
    sep="\t",
    mark=".",
    many=True,
    delta="1.000000E-3",
    unit="Nm",
    day="2026/03/02",
):
    """Return an LVM file of segments, each a mapping of channel names to numbers.

    As in NI's Specification for the LabVIEW Measurement File.
    """
    parts = [
        LVM_HEADER.format(
            sep=sep, name=LVM_SEPARATORS[sep], mark=mark, many="Yes" if many else "No", x=x
        )
    ]
    for channels in segments:
        gap = sep * 2 if x == "Multi" else sep
        between = f"{sep}X_Value{sep}" if x == "Multi" else sep
        count, samples = len(channels), len(next(iter(channels.values())))

        def line(tag, value, gap=gap, count=count):
            return f"{tag}{sep}" + gap.join([value] * count) + sep

        parts.append(
            "\n".join(
                [
                    sep,
                    f"Channels{sep}{count}",
                    line("Samples", str(samples)),
                    line("Date", day),
                    line("Time", f"10:15:01{mark}25"),
                    line("Y_Unit_Label", unit),
                    line("X_Dimension", "Time"),
                    line("X0", f"0{mark}0000000000000000E+0"),
                    line("Delta_X", delta.replace(".", mark)),
                    f"***End_of_Header***{sep * (count + 1)}",
                    f"X_Value{sep}" + between.join(channels) + f"{sep}Comment",
                    *_lvm_rows(channels, x, sep, mark, float(delta)),
                    "",
                ]
            )
        )  # fmt: skip
    return "".join(parts)


def _lvm_rows(channels, x, sep, mark, delta):
    for index, row in enumerate(zip(*channels.values(), strict=True)):
        at = f"{index * delta:.6f}"
        cells = [repr(float(value)) for value in row]
        if x == "Multi":
            text = sep.join(f"{at}{sep}{cell}" for cell in cells)
        else:
            text = sep.join([at if x == "One" else "", *cells])
        yield text.replace(".", mark)


@dataclass(frozen=True)
class Recorded:
    """A recording of a run file: plain numbers, set-points and conditions."""

    name: str
    rate_hz: float
    hertz: float
    newtons: float
    conditions: dict[str, float]
    angle_rad: np.ndarray
    torque_nm: np.ndarray


def recordings_of(run):
    """Return the zero reading of a run of the simulated tester, and its recordings."""
    with h5py.File(run / "run.h5") as file:
        entry = file["entry"]
        recordings = [
            Recorded(
                name,
                float(group.attrs["rate_hz"]),
                float(group["setpoints/tester_frequency"][()]),
                float(group["setpoints/tester_load"][()]),
                {name: float(group["conditions"][name][()]) for name in group["conditions"]},
                group["tester_angle"][()],
                group["tester_torque"][()],
            )
            for name, group in entry["recordings"].items()
        ]
        return float(entry["zeros/tester_torque"][()]), recordings


def write_csv(folder, recorded, _):
    for recording in recorded:
        rows = zip(recording.angle_rad.tolist(), (1e3 * recording.torque_nm).tolist(), strict=True)
        text = "\n".join(
            ["Angle [rad];Torque [mN.m]", *(f"{a!r};{t!r}".replace(".", ",") for a, t in rows)]
        )
        (folder / f"{recording.name}.csv").write_text(text)
    return (
        "csv: {delimiter: ';', decimal: ','}",
        "Angle [rad]",
        "Torque [mN.m]",
        "mN·m",
        "{}.csv",
        "",
    )


def write_lvm(folder, recorded, day):
    for recording in recorded:
        channels = {"Angle": recording.angle_rad.tolist(), "Torque": recording.torque_nm.tolist()}
        text = lvm_text([channels], x="No", mark=",", delta="1.000000E-4", unit="Vain", day=day)
        (folder / f"{recording.name}.lvm").write_text(text)
    return "lvm", "Angle", "Torque", "N·m", "{}.lvm", ""


def write_tdms(folder, recorded, _):
    with TdmsWriter(folder / "all.tdms") as writer:
        for recording in recorded:
            wave = {"wf_increment": 1 / recording.rate_hz}
            units = ("Angle", recording.angle_rad, "rad"), ("Torque", recording.torque_nm, "Nm")
            channels = [
                ChannelObject(recording.name, name, values, {**wave, "unit_string": unit})
                for name, values, unit in units
            ]
            writer.write_segment([RootObject(), GroupObject(recording.name), *channels])
    return "tdms", "Angle", "Torque", "N·m", "all.tdms", "{}"


def write_mat5(folder, recorded, _):
    content = {f"r{rec.name}": {"data": np.c_[rec.angle_rad, rec.torque_nm]} for rec in recorded}
    savemat(folder / "all.mat", content, do_compression=True)
    return "matlab", "data(:,1)", "data(:,2)", "N·m", "all.mat", "r{}"


def write_mat73(folder, recorded, _):
    content = {
        f"r{rec.name}": {"angle": rec.angle_rad[:, None], "torque": rec.torque_nm[:, None]}
        for rec in recorded
    }
    write_matlab_73(folder / "all73.mat", content)
    return "matlab", "angle", "torque", "N·m", "all73.mat", "r{}"


def write_hdf5(folder, recorded, _):
    with h5py.File(folder / "all.h5", "w") as file:
        for recording in recorded:
            file[f"runs/{recording.name}/angle"] = recording.angle_rad
            file[f"runs/{recording.name}/torque"] = recording.torque_nm
            file[f"runs/{recording.name}/torque"].attrs["units"] = "N.m"
    return "hdf5", "angle", "torque", "N·m", "all.h5", "/runs/{}"


WRITERS = {
    "csv": write_csv,
    "hdf5": write_hdf5,
    "lvm": write_lvm,
    "matlab 5": write_mat5,
    "matlab 7.3": write_mat73,
    "tdms": write_tdms,
}
SPECIMEN = (
    "inputs: {specimen: DEMO-0001, type: DEMO-GE20, lot: DEMO-LOT-1, operator: Demo operator}"
)
OPERATOR = "inputs: {operator: Demo operator}"


def export(run, folder, kind, procedure, *, station="simulated", inputs=SPECIMEN):
    """Write the recordings of a run as another program would, and return the mapping."""
    zero_nm, recorded = recordings_of(run)
    day = started_of(run)[:10].replace("-", "/")
    folder.mkdir(parents=True, exist_ok=True)
    format_, angle, torque, unit, file, group = WRITERS[kind](folder, recorded, day)
    wrong = ", file_says: Vain" if kind == "lvm" else ""
    lines = [
        "rigrunner: import/1",
        f"procedure: {procedure}",
        f"station: {station}",
        f"format: {{{format_}}}" if ":" in format_ else f"format: {format_}",
        "program: SwingTest.vi 3.2",
        "by: A. Jones",
        f"started: {started_of(run)}",
        inputs,
        "channels:",
        f"  tester.angle: {{column: '{angle}', unit: rad{wrong}}}",
        f"  tester.torque: {{column: '{torque}', unit: {unit}{wrong}}}",
        f"zeros: {{tester.torque: {zero_nm!r} N·m}}",
        *([] if kind == "tdms" else ["sampling: {rate: 10 kHz}"]),
        "recordings:",
    ]
    for recording in recorded:
        drives = f"tester.frequency: {recording.hertz} Hz, tester.load: {recording.newtons} N"
        lines += [
            f"  - file: {file.format(recording.name)}",
            *([f"    group: {group.format(recording.name)}"] if group else []),
            f"    set_points: {{{drives}}}",
            f"    conditions: {{tester.load: {recording.conditions['tester_load']!r} N}}",
        ]
    path = folder / "mapping.yaml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def started_of(run):
    return read_info(run).header.started_utc


def write_matlab_73(path, content):
    """Write as MATLAB does with -v7.3: transposed, class in an attribute, 512 bytes in front."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in content.items():
            put_matlab_73(file, name, value)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def put_matlab_73(group, name, value):
    if isinstance(value, dict):
        item, kind = group.create_group(name), "struct"
        for field, inner in value.items():
            put_matlab_73(item, field, inner)
    elif isinstance(value, str):
        item, kind = group.create_dataset(name, data=np.frombuffer(value.encode(), "u1")), "char"
    elif hasattr(value, "tocsc"):
        item, kind = group.create_group(name), "double"
        item.create_dataset("data", data=value.data)
        item.attrs["MATLAB_sparse"] = np.uint64(3)
    elif value.dtype == object:
        item = group.create_dataset(name, (2, 1), h5py.ref_dtype)
        kind = "cell"
    elif value.size == 0:
        item, kind = group.create_dataset(name, data=np.zeros(2, "u8")), "double"
        item.attrs["MATLAB_empty"] = np.uint8(1)
    elif np.iscomplexobj(value):
        pairs = np.zeros(value.T.shape, [("real", "f8"), ("imag", "f8")])
        pairs["real"], pairs["imag"] = value.T.real, value.T.imag
        item, kind = group.create_dataset(name, data=pairs), "double"
    else:
        flags = value.dtype == bool
        data = value.T.astype("u1") if flags else value.T
        item = group.create_dataset(name, data=data)
        kind = "logical" if flags else {"f": "double", "i": "int16"}[value.dtype.kind]
    item.attrs["MATLAB_class"] = np.bytes_(kind)
