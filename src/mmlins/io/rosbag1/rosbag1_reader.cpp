// SPDX-License-Identifier: MIT
#include "mmlins/io/rosbag1/rosbag1_reader.hpp"

#include <rosbag/view.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <unordered_map>
#include <utility>

#include "mmlins/io/rosbag1/make_bag.hpp"

namespace mmlins::io {

struct Rosbag1Reader::Impl {
  std::string path;
  std::unique_ptr<rosbag::Bag> bag = make_bag();
  std::vector<BagTopic> topics;
  std::vector<BagConnection> connections;
  std::size_t num_messages = 0;
  Time start_time;
  Time end_time;
  // The library hands out a connection's topic name by reference: its address tells the connection.
  std::unordered_map<const std::string*, std::size_t> topic_of_connection;
  std::unordered_map<const std::string*, std::size_t> number_of_connection;
  std::unique_ptr<rosbag::View> view;
  rosbag::View::iterator position;
  bool at_message = false;  // position points at the message that next() returned last
  std::vector<std::uint8_t> buffer;
};

namespace {

/// What the library needs of a stream: a place to copy the next bytes to.
class BufferStream {
 public:
  explicit BufferStream(std::vector<std::uint8_t>& buffer) : buffer_(buffer) {}
  std::uint8_t* advance(std::uint32_t num_bytes) {
    if (buffer_.size() < num_bytes) buffer_.resize(num_bytes);
    size_ = num_bytes;
    return buffer_.data();
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::vector<std::uint8_t>& buffer_;
  std::size_t size_ = 0;
};

Time to_time(const ros::Time& time) {
  return time_from_ns(static_cast<std::int64_t>(time.sec) * 1'000'000'000 + time.nsec);
}

/// Catches what is clear without the library, in clearer words.
Status check_is_bag(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    return make_error(ErrorCode::kNotFound, "{}: no such file", path);
  }
  if (!std::filesystem::is_regular_file(status)) {
    return make_error(ErrorCode::kInvalid, "{}: not a file; give a ROS 1 bag", path);
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return make_error(ErrorCode::kIo, "{}: cannot be read: {}", path, std::strerror(errno));
  char magic[8] = {};
  file.read(magic, sizeof(magic));
  if (file.gcount() == 0) return make_error(ErrorCode::kInvalid, "{}: the file is empty", path);
  if (file.gcount() != sizeof(magic) || std::memcmp(magic, "#ROSBAG ", sizeof(magic)) != 0) {
    return make_error(ErrorCode::kInvalid, "{}: not a ROS 1 bag (it does not begin with #ROSBAG)", path);
  }
  return {};
}

Error damaged(const std::string& path, const char* what) {
  return make_error(ErrorCode::kInvalid, "{}: damaged or truncated ({}); try: rosbag reindex {}", path, what,
                    path);
}

BagConnection description_of(const rosbag::ConnectionInfo& info) {
  BagConnection connection{info.topic, {info.datatype, info.md5sum, info.msg_def}, {}};
  if (info.header) connection.header.insert(info.header->begin(), info.header->end());
  return connection;
}

using ConnectionQuery = std::function<bool(const rosbag::ConnectionInfo*)>;

}  // namespace

Rosbag1Reader::Rosbag1Reader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Rosbag1Reader::Rosbag1Reader(Rosbag1Reader&&) noexcept = default;
Rosbag1Reader& Rosbag1Reader::operator=(Rosbag1Reader&&) noexcept = default;
Rosbag1Reader::~Rosbag1Reader() = default;

Result<Rosbag1Reader> Rosbag1Reader::open(const std::string& path) {
  if (const Status status = check_is_bag(path); !status.ok()) return status.error();
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  try {
    impl->bag->open(path, rosbag::bagmode::Read);
    rosbag::View all(*impl->bag);
    impl->num_messages = all.size();
    if (impl->num_messages > 0) {
      impl->start_time = to_time(all.getBeginTime());
      impl->end_time = to_time(all.getEndTime());
    }
    std::map<std::pair<std::string, std::string>, std::vector<const rosbag::ConnectionInfo*>> connections;
    for (const auto* connection : all.getConnections()) {
      connections[{connection->topic, connection->datatype}].push_back(connection);
    }
    for (const auto& [topic, members] : connections) {
      for (const auto* connection : members) {
        impl->topic_of_connection[&connection->topic] = impl->topics.size();
        impl->number_of_connection[&connection->topic] = impl->connections.size();
        impl->connections.push_back(description_of(*connection));
      }
      const ConnectionQuery is_member = [&list = members](const rosbag::ConnectionInfo* connection) {
        return std::find(list.begin(), list.end(), connection) != list.end();
      };
      impl->topics.push_back({topic.first, topic.second, rosbag::View(*impl->bag, is_member).size()});
    }
  } catch (const rosbag::BagUnindexedException&) {
    return make_error(ErrorCode::kInvalid,
                      "{}: the bag has no index, its recording was not finished; try: rosbag reindex {}",
                      path, path);
  } catch (const std::exception& exception) {
    return damaged(path, exception.what());
  }
  Rosbag1Reader reader(std::move(impl));
  std::vector<std::size_t> all_topics;
  for (std::size_t i = 0; i < reader.topics().size(); ++i) all_topics.push_back(i);
  if (const Status status = reader.select(all_topics); !status.ok()) return status.error();
  return reader;
}

const std::string& Rosbag1Reader::path() const { return impl_->path; }
const std::vector<BagTopic>& Rosbag1Reader::topics() const { return impl_->topics; }
const std::vector<BagConnection>& Rosbag1Reader::connections() const { return impl_->connections; }
std::size_t Rosbag1Reader::num_messages() const { return impl_->num_messages; }
Time Rosbag1Reader::start_time() const { return impl_->start_time; }
Time Rosbag1Reader::end_time() const { return impl_->end_time; }

Result<std::vector<Time>> Rosbag1Reader::record_times(std::size_t topic) const {
  std::vector<Time> times;
  times.reserve(impl_->topics[topic].num_messages);
  try {
    const ConnectionQuery is_topic = [this, topic](const rosbag::ConnectionInfo* connection) {
      return impl_->topic_of_connection.at(&connection->topic) == topic;
    };
    rosbag::View view(*impl_->bag, is_topic);
    for (const auto& message : view) times.push_back(to_time(message.getTime()));
  } catch (const std::exception& exception) {
    return damaged(impl_->path, exception.what());
  }
  return times;
}

Status Rosbag1Reader::select(const std::vector<std::size_t>& topics) {
  try {
    const ConnectionQuery is_selected = [this, &topics](const rosbag::ConnectionInfo* connection) {
      const std::size_t topic = impl_->topic_of_connection.at(&connection->topic);
      return std::find(topics.begin(), topics.end(), topic) != topics.end();
    };
    impl_->position = rosbag::View::iterator();  // it refers to the view that goes
    impl_->view = std::make_unique<rosbag::View>(*impl_->bag, is_selected);
    impl_->position = impl_->view->begin();
    impl_->at_message = false;
  } catch (const std::exception& exception) {
    return damaged(impl_->path, exception.what());
  }
  return {};
}

Result<std::optional<RawMessage>> Rosbag1Reader::next() {
  try {
    if (impl_->at_message) ++impl_->position;
    impl_->at_message = false;
    if (impl_->position == impl_->view->end()) return std::optional<RawMessage>();
    const rosbag::MessageInstance& message = *impl_->position;
    BufferStream stream(impl_->buffer);
    message.write(stream);
    impl_->at_message = true;
    return std::optional<RawMessage>(RawMessage{
        impl_->topic_of_connection.at(&message.getTopic()), impl_->number_of_connection.at(&message.getTopic()),
        to_time(message.getTime()), impl_->buffer.data(), stream.size()});
  } catch (const std::exception& exception) {
    impl_->position = impl_->view->end();
    return damaged(impl_->path, exception.what());
  }
}

}  // namespace mmlins::io
