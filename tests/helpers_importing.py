"""Files as other programs write them."""

from __future__ import annotations

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


def lvm_text(segments, *, x="One", sep="\t", mark=".", many=True, delta="1.000000E-3", unit="Nm"):
    """Return an LVM file of segments, each a mapping of channel names to numbers.

    As NI's Specification for the LabVIEW Measurement File has it.
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
                    line("Date", "2026/03/02"),
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
