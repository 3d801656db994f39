# SPDX-License-Identifier: MIT
"""Writes and reads bags by libraries that share nothing with mmlins: the PyPI package rosbags, or Debian's
python3-rosbag. Both serialise the messages themselves, from the types' definitions.

    writer = find_library()                         None: neither can be imported
    writer.write(path, [(topic, type, record_ns, {field: value}), ...])
"""

import os
import sys

SEPARATOR = "=" * 80 + "\n"
HEADER = SEPARATOR + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
VECTOR = SEPARATOR + "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
CUSTOM_POINT = """uint32 offset_time
float32 x
float32 y
float32 z
uint8 reflectivity
uint8 tag
uint8 line
"""
CUSTOM_MSG = """std_msgs/Header header
uint64 timebase
uint32 point_num
uint8 lidar_id
uint8[3] rsvd
CustomPoint[] points
"""
DEFINITIONS = {
    "sensor_msgs/PointCloud2": """std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
""" + HEADER + SEPARATOR + """MSG: sensor_msgs/PointField
string name
uint32 offset
uint8 datatype
uint32 count
""",
    "sensor_msgs/Imu": """std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
""" + HEADER + VECTOR + SEPARATOR + "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
    "std_msgs/String": "string data\n",
}
for _driver in ["livox_ros_driver", "livox_ros_driver2"]:
    DEFINITIONS[f"{_driver}/CustomMsg"] = (CUSTOM_MSG + HEADER + SEPARATOR + f"MSG: {_driver}/CustomPoint\n" +
                                           CUSTOM_POINT)


class Rosbags:
    """The package rosbags."""

    def __init__(self):
        import numpy
        from rosbags.rosbag1 import Reader, Writer
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
        self.numpy, self.Reader, self.Writer = numpy, Reader, Writer
        self.store = get_typestore(Stores.ROS1_NOETIC)
        for driver in ["livox_ros_driver", "livox_ros_driver2"]:
            self.store.register({**get_types_from_msg(CUSTOM_POINT, f"{driver}/msg/CustomPoint"),
                                 **get_types_from_msg(CUSTOM_MSG, f"{driver}/msg/CustomMsg")})

    def build(self, type_name, fields):
        """A message of the library from a dictionary, by the definition of its type."""
        definition = dict(self.store.fielddefs[type_name][1])
        values = {name: self.convert(definition[name], fields.get(name)) for name in definition}
        return self.store.types[type_name](**values)

    def convert(self, node, value):
        kind, detail = node
        kind = getattr(kind, "name", str(kind))
        if kind == "NAME" and detail == "builtin_interfaces/msg/Time":
            return self.store.types[detail](sec=value // 10**9, nanosec=value % 10**9)
        if kind == "NAME":
            return self.build(detail, value or {})
        if kind == "BASE":
            return value if value is not None else {"string": "", "bool": False}.get(detail[0], 0)
        element, length = detail[0], detail[1]
        if getattr(element[0], "name", "") == "NAME":
            return [self.build(element[1], item) for item in value or []]
        dtype = element[1][0]
        if isinstance(value, (bytes, bytearray)):
            return self.numpy.frombuffer(bytes(value), self.numpy.uint8)
        return self.numpy.array(value if value is not None else [0] * length, dtype)

    def write(self, path, messages):
        with self.Writer(path) as writer:
            connections = {}
            for topic, type_name, record_ns, fields in messages:
                full_name = type_name.replace("/", "/msg/")
                if (topic, type_name) not in connections:
                    connections[topic, type_name] = writer.add_connection(topic, full_name, typestore=self.store)
                data = self.store.serialize_ros1(self.build(full_name, fields), full_name)
                writer.write(connections[topic, type_name], record_ns, data)

    def read(self, path):
        """(topic, record_ns, message) of all; the types are those that the library knows itself."""
        with self.Reader(path) as reader:
            for connection in reader.connections:
                _, md5sum = self.store.generate_msgdef(connection.msgtype, ros_version=1)
                assert md5sum == connection.digest, (connection.msgtype, md5sum, connection.digest)
            return [(connection.topic, record_ns, self.store.deserialize_ros1(data, connection.msgtype))
                    for connection, record_ns, data in reader.messages()]

    @staticmethod
    def stamp_ns(message):
        return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


class DebianRosbag:
    """Debian's python3-rosbag."""

    def __init__(self):
        import genpy
        import genpy.dynamic
        import rosbag
        self.genpy, self.rosbag = genpy, rosbag
        self.types = {}
        for name, definition in DEFINITIONS.items():
            self.types.update(genpy.dynamic.generate_dynamic(name, definition))

    def fill(self, message, fields):
        for name, value in fields.items():
            index = message.__slots__.index(name)
            type_name = message._slot_types[index]
            if type_name == "time":
                value = self.genpy.Time(value // 10**9, value % 10**9)
            elif isinstance(value, dict):
                value = self.fill(getattr(message, name), value)
            elif isinstance(value, list) and value and isinstance(value[0], dict):
                element = type_name[:-2] if "/" in type_name else message._type.split("/")[0] + "/" + type_name[:-2]
                value = [self.fill(self.types[element](), item) for item in value]
            setattr(message, name, value)
        return message

    def write(self, path, messages):
        with self.rosbag.Bag(str(path), "w") as bag:
            for topic, type_name, record_ns, fields in messages:
                message = self.fill(self.types[type_name](), fields)
                bag.write(topic, message, self.genpy.Time(record_ns // 10**9, record_ns % 10**9))

    def read(self, path):
        with self.rosbag.Bag(str(path)) as bag:
            for connection in bag._get_connections():
                generated = self.genpy.dynamic.generate_dynamic(connection.datatype, connection.msg_def)
                md5sum = generated[connection.datatype]._md5sum
                assert md5sum == connection.md5sum, (connection.datatype, md5sum, connection.md5sum)
            return [(topic, time.to_nsec(), message) for topic, message, time in bag.read_messages()]

    @staticmethod
    def stamp_ns(message):
        return message.header.stamp.to_nsec()


def find_library():
    """The first library that works here; runs the script again by the system's Python if only that has one."""
    for library in [Rosbags, DebianRosbag]:
        try:
            return library()
        except ImportError:
            continue
    system_python = "/usr/bin/python3"
    if os.path.exists(system_python) and "BAG_WRITERS_RETRIED" not in os.environ:
        os.environ["BAG_WRITERS_RETRIED"] = "1"
        os.execv(system_python, [system_python, *sys.argv])
    return None
