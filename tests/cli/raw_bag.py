# SPDX-License-Identifier: MIT
"""Reads ROS 1 bags as raw bytes, from the description of the format alone, without any library."""

import bz2
import struct


def fields_of(header):
    fields = {}
    while header:
        (length,) = struct.unpack_from("<I", header)
        name, _, value = header[4:4 + length].partition(b"=")
        fields[name.decode()] = value
        header = header[4 + length:]
    return fields


def records(data):
    at = 0
    while at < len(data):
        (length,) = struct.unpack_from("<I", data, at)
        header = fields_of(data[at + 4:at + 4 + length])
        at += 4 + length
        (length,) = struct.unpack_from("<I", data, at)
        yield header, data[at + 4:at + 4 + length]
        at += 4 + length


def read_raw(path):
    """[(topic, connection header, record time [ns], bytes), ...] in the order of the file."""
    with open(path, "rb") as file:
        content = file.read()
    first_line, _, rest = content.partition(b"\n")
    assert first_line == b"#ROSBAG V2.0", first_line
    connections, messages = {}, []

    def read(data):
        for header, body in records(data):
            operation = header["op"]
            if operation == b"\x05":
                assert header["compression"] in (b"none", b"bz2"), header["compression"]
                read(bz2.decompress(body) if header["compression"] == b"bz2" else body)
            elif operation == b"\x07":
                connections[header["conn"]] = (header["topic"].decode(), fields_of(body))
            elif operation == b"\x02":
                seconds, nanoseconds = struct.unpack("<II", header["time"])
                messages.append((*connections[header["conn"]], seconds * 10**9 + nanoseconds, body))

    read(rest)
    return messages


class Cloud:
    """A sensor_msgs/PointCloud2 taken apart."""

    def __init__(self, data):
        sequence, seconds, nanoseconds, length = struct.unpack_from("<IIII", data)
        self.stamp = seconds * 10**9 + nanoseconds
        at = 16 + length
        self.height, self.width, count = struct.unpack_from("<III", data, at)
        at += 12
        self.offsets = {}
        for _ in range(count):
            (length,) = struct.unpack_from("<I", data, at)
            name = data[at + 4:at + 4 + length].decode()
            self.offsets[name], self.kind, _ = struct.unpack_from("<IBI", data, at + 4 + length)
            at += 4 + length + 9
        _, self.step, self.row_step, length = struct.unpack_from("<BIII", data, at)
        self.data = data[at + 13:at + 13 + length]
        self.is_dense = data[at + 13 + length]
        assert at + 14 + length == len(data)
        assert self.height == 0 or self.row_step * self.height == len(self.data)

    def points(self):
        return [self.data[i:i + self.step] for i in range(0, len(self.data), self.step)]

    def value(self, point, name, layout="<f"):
        return struct.unpack_from(layout, point, self.offsets[name])[0]
