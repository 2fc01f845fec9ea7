#!/usr/bin/env python3
"""Makes the files beside it: the rows of run.csv as spreadsheets and MATLAB files.

The writers know nothing of this project: openpyxl, odfpy, scipy and h5py, of Debian's packages
python3-openpyxl, python3-odf, python3-scipy and python3-h5py. The files are kept, so that no test needs these.
"""

import datetime
import pathlib
import random
import struct
import zipfile

import h5py
import numpy as np
import openpyxl
import scipy.io
from odf.opendocument import OpenDocumentSpreadsheet
from odf.style import Style, TableProperties
from odf.table import Table, TableCell, TableRow
from odf.text import P

HERE = pathlib.Path(__file__).parent
NAMES = ["time_s", "current_mA", "voltage_V", "load_N"]
LONG_AGO = (1980, 1, 1, 0, 0, 0)


def rows(count=30):
    """Numbers of 15 digits, since openpyxl writes no more than 16."""
    dice = random.Random(7)
    return [[round(0.01 * i, 2), float(f"{dice.uniform(1, 400):.15g}"), float(f"{dice.uniform(0, 4):.15g}"),
             float(f"{dice.uniform(0, 2):.15g}")] for i in range(count)]


def write_csv(table):
    lines = [",".join(NAMES)] + [",".join(f"{value!r}" for value in row) for row in table]
    (HERE / "run.csv").write_text("\n".join(lines) + "\n")


def write_xlsx(table):
    book = openpyxl.Workbook()
    notes = book.active
    notes.title = "Notes"
    notes.append(["made on", datetime.datetime(2026, 11, 28)])
    notes.append([1, 2, 3])
    sheet = book.create_sheet('Run 3, "warm"\x7f')
    sheet.append(["Bench 3"])
    sheet.append([])
    sheet.append([None, "Time [s]", "I [mA]", "Voltage (V)", "Load [N]", 'note, by "me"\nand us'])
    for i, row in enumerate(table):
        sheet.append([None, *row] + (["a note, with a comma"] if i == 4 else []))
    hidden = book.create_sheet("Old")
    hidden.sheet_state = "hidden"
    for i in range(100):
        hidden.append([i, i, i])
    book.save(HERE / "run.xlsx")
    clock = openpyxl.Workbook()
    clock.active.append(["Time [s]", "clock", "I [mA]"])
    start = datetime.datetime(2026, 11, 28, 12, 30)
    for i in range(4):
        at = start + datetime.timedelta(milliseconds=250 * i)
        clock.active.append([at, at.time(), 1.5 * i])
    clock.save(HERE / "clock.xlsx")


def write_by_hand(table):
    """As Excel writes: numbers in 17 digits, shared texts in several fonts, results of formulas, errors; the last
    rows and cells do not say where they are."""
    texts = ["Time [s]", "I [mA]", "Voltage (V)", "Load [N]"]
    shared = "".join(f"<si><r><t>{t[:2]}</t></r><r><t xml:space='preserve'>{t[2:]}</t></r>"
                     "<rPh><t>spoken</t></rPh></si>" for t in texts)
    lines = ["<row r='1'>" + "".join(f"<c r='{c}1' t='s'><v>{i}</v></c>" for i, c in enumerate("ABCD")) + "</row>"]
    for n, row in enumerate(table, 2):
        said = n < 20
        cells = "".join(f"<c{f' r={chr(39)}{c}{n}{chr(39)}' if said else ''}><f>1+1</f><v>{value:.17G}</v></c>"
                        for c, value in zip("ABCD", row))
        lines.append(f"<row{f' r={chr(39)}{n}{chr(39)}' if said else ''}>{cells}</row>")
    office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    parts = {
        "[Content_Types].xml": "<Types/>",
        "_rels/.rels": f"<Relationships><Relationship Id='r1' Type='{office}/officeDocument' "
                       "Target='xl/workbook.xml'/></Relationships>",
        "xl/workbook.xml": "<workbook xmlns:r='r'><sheets><sheet name='Chart' sheetId='2' r:id='c'/>"
                           "<sheet name='S' sheetId='1' r:id='a'/></sheets></workbook>",
        "xl/_rels/workbook.xml.rels":
            f"<Relationships><Relationship Id='a' Type='{office}/worksheet' Target='/xl/worksheets/s.xml'/>"
            f"<Relationship Id='c' Type='{office}/chartsheet' Target='charts/c.xml'/>"
            f"<Relationship Id='b' Type='{office}/sharedStrings' Target='shared.xml'/></Relationships>",
        "xl/shared.xml": f"<sst>{shared}</sst>",
        "xl/worksheets/s.xml": f"<worksheet><sheetData>{''.join(lines)}</sheetData></worksheet>",
    }
    write_zip("by_hand.xlsx", parts)
    # Other archives.
    write_zip("no_sheet.zip", {"run.csv": "time_s,current_A\n0,1\n"})
    write_zip("encrypted.ods", {"mimetype": "application/vnd.oasis.opendocument.spreadsheet",
                                "META-INF/manifest.xml": "<manifest><encryption-data/></manifest>",
                                "content.xml": "?"})
    empty = dict(parts)
    empty["xl/worksheets/s.xml"] = f"<worksheet><sheetData>{lines[0]}</sheetData></worksheet>"
    write_zip("no_rows.xlsx", empty)
    bomb = dict(parts)
    bomb["xl/worksheets/s.xml"] = ("<!DOCTYPE x [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]>"
                                   "<worksheet>&b;</worksheet>")
    write_zip("entities.xlsx", bomb)
    write_zip("repeated.ods", {
        "mimetype": "application/vnd.oasis.opendocument.spreadsheet",
        "content.xml": "<d xmlns:t='t' xmlns:o='o'><t:table t:name='x'><t:table-row t:number-rows-repeated='4000000000'>"
                       "<t:table-cell o:value-type='float' o:value='1' t:number-columns-repeated='4000000000'/>"
                       "</t:table-row></t:table></d>"})


def write_zip(name, parts):
    with zipfile.ZipFile(HERE / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for part, text in parts.items():
            archive.writestr(zipfile.ZipInfo(part, LONG_AGO), text, zipfile.ZIP_DEFLATED)


def write_ods(table):
    book = OpenDocumentSpreadsheet()
    hidden = Style(name="hidden", family="table")
    hidden.addElement(TableProperties(display="false"))
    book.automaticstyles.addElement(hidden)
    old = Table(name="Old", stylename=hidden)
    for i in range(100):
        old.addElement(ods_row([i, i, i]))
    book.spreadsheet.addElement(old)
    sheet = Table(name="Lauf 1")
    sheet.addElement(ods_row(["Time [s]", "I [mA]", "U [V]", "Force [N]", "note"]))
    for i, row in enumerate(table):
        line = ods_row(row + (["warm"] if i == 2 else []))
        line.addElement(TableCell(numbercolumnsrepeated=1000))
        sheet.addElement(line)
    sheet.addElement(TableRow(numberrowsrepeated=1000000))
    book.spreadsheet.addElement(sheet)
    book.save(HERE / "run.ods")


def ods_row(values):
    line = TableRow()
    for value in values:
        if isinstance(value, str):
            cell = TableCell(valuetype="string")
            cell.addElement(P(text=value))
        else:
            cell = TableCell(valuetype="float", value=repr(value))
            cell.addElement(P(text=f"{value:.2f}"))
        line.addElement(cell)
    return line


def write_mat5(table):
    columns = {name: np.array(values) for name, values in zip(NAMES, zip(*table))}
    scipy.io.savemat(HERE / "run_5.mat", {"fs": 100.0, "note": "warm", **columns, "gain": np.array([1.0, 2, 3])},
                     do_compression=True)
    # Columns instead of rows, in a struct.
    scipy.io.savemat(HERE / "struct_5.mat", {"run": {**columns, "operator": "me", "fs": 100.0}}, oned_as="column")
    matrix = np.array(table)
    names = np.array(["Time [s]", "I [mA]", "U [V]", "Force / N"], dtype=object)
    scipy.io.savemat(HERE / "matrix_5.mat", {"data": matrix.T, "names": names}, do_compression=True)
    scipy.io.savemat(HERE / "bare_5.mat", {"data": matrix}, do_compression=True)
    kinds = {"time_s": np.arange(4, dtype=np.int16), "current_A": np.array([0.1, 0.2, np.nan, 0.4], np.float32),
             "voltage_V": np.array([1, 2, 3, 4], np.uint64), "emergency_stop": np.array([True, False, True, False]),
             "z": np.array([1j, 2, 3, 4])}
    scipy.io.savemat(HERE / "kinds_5.mat", kinds)
    scipy.io.savemat(HERE / "nothing_5.mat", {"z": np.array([1j, 2]), "cube": np.zeros((2, 2, 2)), "name": "x",
                                              "t": 1.0, "none": np.zeros((0, 0))})


def write_objects():
    """A variable 'T' of class table, as MATLAB writes it: its content would be in another variable."""
    def part(kind, data):
        return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)

    numbers = part(14, part(6, struct.pack("<II", 13, 0)) + part(5, struct.pack("<ii", 1, 6)) + part(1, b"")
                   + part(6, struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1)))
    table = part(14, part(6, struct.pack("<II", 17, 0)) + part(1, b"T") + part(1, b"MCOS") + part(1, b"table")
                 + numbers)
    head = b"MATLAB 5.0 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x01IM"
    (HERE / "object_5.mat").write_bytes(head + table)
    path = HERE / "object_73.mat"
    with h5py.File(path, "w", userblock_size=512, libver="earliest") as file:
        add_array(file, "T", np.array([[0xDD000000, 2, 1, 1, 1, 1]], dtype=np.uint32), "table")
        file["T"].attrs["MATLAB_object_decode"] = np.int32(3)
    add_head(path)


def write_mat73(table):
    """What MATLAB writes: HDF5 behind a header of 512 bytes, its classes as attributes."""
    path = HERE / "run_73.mat"
    with h5py.File(path, "w", userblock_size=512, libver="earliest") as file:
        for name, values in zip(NAMES, zip(*table)):
            add_array(file, name, np.array([values]), "double")
        add_array(file, "fs", np.array([[100.0]]), "double")
    add_head(path)


def add_head(path):
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Sat Nov 28 12:00:00 2026 HDF5 schema 1.00 ."
    with open(path, "r+b") as file:
        file.write(text.ljust(116) + bytes(8) + b"\x00\x02IM")


def add_array(group, name, values, kind):
    data = group.create_dataset(name, data=values, track_times=False)
    text = h5py.h5t.C_S1.copy()
    text.set_size(len(kind))
    place = h5py.h5s.create(h5py.h5s.SCALAR)
    attribute = h5py.h5a.create(data.id, b"MATLAB_class", text, place)
    attribute.write(np.array(kind.encode(), dtype=f"S{len(kind)}"), mtype=text)


def main():
    table = rows()
    write_csv(table)
    write_xlsx(table)
    write_by_hand(table)
    write_ods(table)
    write_mat5(table)
    write_objects()
    write_mat73(table)


main()
