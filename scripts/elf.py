# SPDX-License-Identifier: MIT OR Apache-2.0
"""Reads of a 64-bit little-endian ELF file what matters for handing it on: the libraries and the symbol versions that it
needs, and its rpath, which can be shortened.

Structures by the System V ABI (gABI chapters 4 and 5) and, for symbol versions, the Linux Standard Base.
"""

import struct

PT_LOAD, PT_DYNAMIC = 1, 2
DT_NEEDED, DT_STRTAB, DT_SONAME, DT_RPATH, DT_RUNPATH = 1, 5, 14, 15, 29
DT_VERNEED, DT_VERNEEDNUM = 0x6FFFFFFE, 0x6FFFFFFF
SHT_DYNSYM, SHT_VERDEF = 11, 0x6FFFFFFD


class Elf:
    """One ELF file in memory."""

    def __init__(self, data, name="the file"):
        self.data = bytearray(data)
        self.name = name
        if self.data[:6] != b"\x7fELF\x02\x01":
            raise ValueError(f"{name} is not a 64-bit little-endian ELF file")
        self.loads = []
        self.dynamic = []
        start, size, count = struct.unpack_from("<Q", self.data, 32) + struct.unpack_from("<HH", self.data, 54)
        for index in range(count):
            kind, _, offset, address, _, in_file = struct.unpack_from("<IIQQQQ", self.data, start + index * size)
            if kind == PT_LOAD:
                self.loads.append((address, offset, in_file))
            elif kind == PT_DYNAMIC:
                self.dynamic = [entry for entry in struct.iter_unpack("<qQ", self.data[offset:offset + in_file]) if entry[0]]
        if not self.dynamic:
            raise ValueError(f"{name} is not dynamically linked")
        self.strings = self.at(self.value(DT_STRTAB))

    def at(self, address):
        """The place in the file of an address in memory."""
        for begin, offset, size in self.loads:
            if begin <= address < begin + size:
                return offset + address - begin
        raise ValueError(f"{self.name}: the address {address:#x} is in no segment")

    def value(self, tag):
        return next((value for found, value in self.dynamic if found == tag), None)

    def text(self, offset):
        begin = self.strings + offset
        return self.data[begin:self.data.index(0, begin)].decode()

    def needed(self):
        """The names of the libraries that it asks for."""
        return [self.text(value) for tag, value in self.dynamic if tag == DT_NEEDED]

    def rpath(self):
        """Where it has its libraries looked for: a list of folders."""
        found = [self.text(value) for tag, value in self.dynamic if tag in (DT_RPATH, DT_RUNPATH)]
        return [folder for folders in found for folder in folders.split(":")]

    def _verneed(self):
        """The records of needed versions: (offset of the library's name, [offset of the version's name])."""
        records = []
        at = self.value(DT_VERNEED)
        at = self.at(at) if at is not None else 0
        for _ in range(self.value(DT_VERNEEDNUM) or 0):
            _, count, file, first, following = struct.unpack_from("<HHIII", self.data, at)
            names, inner = [], at + first
            for _ in range(count):
                _, _, _, name, after = struct.unpack_from("<IHHII", self.data, inner)
                names.append(name)
                inner += after
            records.append((file, names))
            at += following
        return records

    def versions(self):
        """The symbol versions that it asks for: {"GLIBC_2.34", …}."""
        return {self.text(name) for _, names in self._verneed() for name in names}

    def cut_rpath(self, wanted):
        """Shortens the rpath to its first entries, in place (the string table keeps its size).

        A linker lets strings share their ends: where another one begins in what would be overwritten, that is an error.
        """
        entries = [(tag, value) for tag, value in self.dynamic if tag in (DT_RPATH, DT_RUNPATH)]
        if len(entries) != 1 or self.rpath()[:len(wanted)] != wanted:
            raise ValueError(f"{self.name}: the rpath {':'.join(self.rpath())} does not begin with {':'.join(wanted)}")
        begin = entries[0][1]
        old_end, new_end = begin + len(self.text(begin)), begin + len(":".join(wanted))
        for offset in self._name_offsets():
            if begin < offset < old_end:
                raise ValueError(f"{self.name}: a name shares its end with the rpath, which can't be shortened then")
        self.data[self.strings + new_end:self.strings + old_end] = bytes(old_end - new_end)

    def _name_offsets(self):
        """The places in the string table of all other names."""
        for tag, value in self.dynamic:
            if tag in (DT_NEEDED, DT_SONAME):
                yield value
        for file, names in self._verneed():
            yield file
            yield from names
        start, = struct.unpack_from("<Q", self.data, 40)
        size, count = struct.unpack_from("<HH", self.data, 58)
        for index in range(count):
            _, kind, _, _, offset, length = struct.unpack_from("<IIQQQQ", self.data, start + index * size)
            if kind == SHT_VERDEF:
                raise ValueError(f"{self.name} defines symbol versions: its rpath can't be shortened safely")
            if kind == SHT_DYNSYM:
                for symbol in range(offset, offset + length, 24):
                    yield struct.unpack_from("<I", self.data, symbol)[0]
