// SPDX-License-Identifier: MIT
#include "mmlins/io/rosbag1/rosbag1_raw_writer.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

#include "mmlins/base/text_file.hpp"
#include "mmlins/io/rosbag1/make_bag.hpp"

namespace mmlins::io {
namespace {

/// A serialised message in the shape that the library's templates ask for.
struct RawContent {
  const MessageType* type;
  const std::uint8_t* data;
  std::size_t size;
};

}  // namespace
}  // namespace mmlins::io

namespace ros {
namespace message_traits {
template <>
struct MD5Sum<mmlins::io::RawContent> {
  static const char* value(const mmlins::io::RawContent& content) { return content.type->md5sum.c_str(); }
};
template <>
struct DataType<mmlins::io::RawContent> {
  static const char* value(const mmlins::io::RawContent& content) { return content.type->name.c_str(); }
};
template <>
struct Definition<mmlins::io::RawContent> {
  static const char* value(const mmlins::io::RawContent& content) { return content.type->definition.c_str(); }
};
}  // namespace message_traits

namespace serialization {
template <>
struct Serializer<mmlins::io::RawContent> {
  template <typename Stream>
  static void write(Stream& stream, const mmlins::io::RawContent& content) {
    if (content.size > 0) std::memcpy(stream.advance(content.size), content.data, content.size);
  }
  static std::uint32_t serializedLength(const mmlins::io::RawContent& content) {
    return static_cast<std::uint32_t>(content.size);
  }
};
}  // namespace serialization
}  // namespace ros

namespace mmlins::io {

struct Rosbag1RawWriter::Impl {
  std::string path;
  std::string temporary_path;
  std::unique_ptr<rosbag::Bag> bag = make_bag();
  bool is_open = false;
  struct Connection {
    std::string topic;
    MessageType type;
    boost::shared_ptr<ros::M_string> header;
  };
  std::vector<Connection> connections;

  Status write(const std::string& topic, Time record_time, const RawContent& content,
               const boost::shared_ptr<ros::M_string>& header);
  template <typename Work>
  Status attempt(const Work& work) const;

  ~Impl() {
    if (is_open) throw_away();
  }

 private:
  void throw_away();
};

void Rosbag1RawWriter::Impl::throw_away() {
  std::error_code ignored;
  std::filesystem::resize_file(temporary_path, 0, ignored);  // on a full disk closing would fail for want of space
  std::filesystem::remove(temporary_path, ignored);
  if (!attempt([this] { bag->close(); })) (void)bag.release();  // its destructor would fail again, and end the program
}

/// The library's exceptions say what it was doing; why it failed is what the system said last.
template <typename Work>
Status Rosbag1RawWriter::Impl::attempt(const Work& work) const {
  errno = 0;
  try {
    work();
    return {};
  } catch (const std::exception& exception) {
    if (const int reason = errno; reason != 0) return cannot_write(path, reason);
    return make_error(ErrorCode::kIo, "{}: cannot be written: {}", path, exception.what());
  }
}

Rosbag1RawWriter::Rosbag1RawWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Rosbag1RawWriter::Rosbag1RawWriter(Rosbag1RawWriter&&) noexcept = default;
Rosbag1RawWriter& Rosbag1RawWriter::operator=(Rosbag1RawWriter&&) noexcept = default;
Rosbag1RawWriter::~Rosbag1RawWriter() = default;

Result<Rosbag1RawWriter> Rosbag1RawWriter::create(const std::string& path) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->temporary_path = path + ".part";
  if (std::filesystem::is_directory(path)) {
    return make_error(ErrorCode::kIo, "{}: is a folder; give a file name", path);
  }
  if (!std::ofstream(impl->temporary_path, std::ios::binary)) {
    return cannot_write(path, errno);
  }
  impl->is_open = true;
  const Status opened = impl->attempt([&impl] { impl->bag->open(impl->temporary_path, rosbag::bagmode::Write); });
  if (!opened) return opened.error();
  return Rosbag1RawWriter(std::move(impl));
}

Status Rosbag1RawWriter::Impl::write(const std::string& topic, Time record_time, const RawContent& content,
                                     const boost::shared_ptr<ros::M_string>& header) {
  if (!is_open) return make_error(ErrorCode::kIo, "{}: is closed already", path);
  const std::int64_t ns = to_ns(record_time);
  if (ns <= 0 || ns / 1'000'000'000 > 0xffffffffLL) {
    return make_error(ErrorCode::kInvalid, "{}: {}: record time {} ns does not fit into a bag (1970 to 2106)",
                      path, topic, ns);
  }
  const ros::Time time(static_cast<std::uint32_t>(ns / 1'000'000'000),
                       static_cast<std::uint32_t>(ns % 1'000'000'000));
  return attempt([&] { bag->write(topic, time, content, header); });
}

Status Rosbag1RawWriter::write(const std::string& topic, const MessageType& type, Time record_time,
                               const std::uint8_t* data, std::size_t size) {
  return impl_->write(topic, record_time, RawContent{&type, data, size}, {});
}

std::size_t Rosbag1RawWriter::add_connection(const BagConnection& connection) {
  auto header = boost::make_shared<ros::M_string>(connection.header.begin(), connection.header.end());
  impl_->connections.push_back({connection.topic, connection.type, std::move(header)});
  return impl_->connections.size() - 1;
}

Status Rosbag1RawWriter::write_to(std::size_t connection, Time record_time, const std::uint8_t* data,
                                  std::size_t size) {
  const Impl::Connection& to = impl_->connections.at(connection);
  return impl_->write(to.topic, record_time, RawContent{&to.type, data, size}, to.header);
}

Status Rosbag1RawWriter::close() {
  if (!impl_->is_open) return make_error(ErrorCode::kIo, "{}: is closed already", impl_->path);
  if (const Status closed = impl_->attempt([this] { impl_->bag->close(); }); !closed) return closed;
  if (std::rename(impl_->temporary_path.c_str(), impl_->path.c_str()) != 0) return cannot_write(impl_->path, errno);
  impl_->is_open = false;
  return {};
}

}  // namespace mmlins::io
