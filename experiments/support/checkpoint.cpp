// Little-endian: "FEDERCP2", file size, scene hash, frame, step; t; q, v, lambda, force, each with its count;
// suggested dt, last dt, contacts with their count; number of files, each with the length of its name, the name, its length; FNV-1a 64
// of all before. A step of FNV-1a is one-to-one both in the hash and in the byte, so that no change of a
// single byte goes unseen. Whole numbers have 64 bits.
#include "experiments/support/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "engine/check.h"
#include "experiments/support/files.h"

namespace feder::experiments {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie in memory");

namespace {

constexpr std::string_view kMagic = "FEDERCP2";
constexpr std::size_t kSizeAt = kMagic.size(), kWord = 8;

std::uint64_t checksum(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

class Writer {
 public:
  template <class Number>
  void add(const Number& value) {
    static_assert(sizeof value == kWord);
    bytes.append(reinterpret_cast<const char*>(&value), kWord);
  }
  void add(const VectorXd& values) {
    add(std::int64_t{values.size()});
    bytes.append(reinterpret_cast<const char*>(values.data()),
                 kWord * static_cast<std::size_t>(values.size()));
  }
  void add(const std::string& text) {
    add(static_cast<std::int64_t>(text.size()));
    bytes += text;
  }

  std::string bytes;
};

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& place) : bytes_(bytes), place_(place) {}

  [[noreturn]] void fail(std::size_t at, const std::string& value, const std::string& expected) const {
    throw InputError(fmt::format("{}: byte {}: {}, expected {}", place_, at, value, expected));
  }

  template <class Number>
  Number number(const char* what) {
    static_assert(sizeof(Number) == kWord);
    need(kWord, what);
    Number value;
    std::memcpy(&value, bytes_.data() + at_, kWord);
    at_ += kWord;
    return value;
  }
  double finite(const char* what) {
    const double value = number<double>(what);
    if (!std::isfinite(value)) fail(at_ - kWord, fmt::format("{} = {}", what, value), "a finite number");
    return value;
  }
  std::int64_t not_negative(const char* what) {
    const std::int64_t value = number<std::int64_t>(what);
    if (value < 0) fail(at_ - kWord, fmt::format("{} = {}", what, value), "0 or more");
    return value;
  }
  /// A count of things that take at least `least` bytes each of what is left.
  std::size_t count(const char* what, std::size_t least) {
    const auto value = static_cast<std::uint64_t>(not_negative(what));
    if (value > left() / least)
      fail(at_ - kWord, fmt::format("{} = {}", what, value),
           fmt::format("at most {}, what {} bytes can hold", left() / least, left()));
    return value;
  }
  VectorXd vector(const char* what) {
    VectorXd values(static_cast<Eigen::Index>(count(what, kWord)));
    for (double& value : values) value = finite(what);
    return values;
  }
  std::string text(const char* what) {
    const std::size_t size = count(what, 1);
    at_ += size;
    return std::string(bytes_.substr(at_ - size, size));
  }

  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }
  void skip(std::size_t count) { at_ += count; }
  void drop_last(std::size_t count) { bytes_.remove_suffix(count); }
  std::string_view bytes() const { return bytes_; }

 private:
  void need(std::size_t count, const char* what) const {
    if (left() < count)
      fail(at_, fmt::format("{} bytes left", left()), fmt::format("{} for {}", count, what));
  }

  std::string_view bytes_;
  const std::string& place_;
  std::size_t at_ = 0;
};

/// Magic, version, size and checksum; leaves the reader before the scene hash, without the checksum.
void open_envelope(Reader& in) {
  const std::string_view bytes = in.bytes(), name = kMagic.substr(0, kMagic.size() - 1);
  if (!bytes.starts_with(name))
    in.fail(0, fmt::format("the first of {} bytes are no checkpoint's", bytes.size()),
            fmt::format("'{}'", kMagic));
  if (bytes.size() < kMagic.size() || bytes[name.size()] != kMagic.back())
    in.fail(name.size(),
            bytes.size() == name.size()
                ? "the end"
                : fmt::format("version {}", static_cast<int>(static_cast<unsigned char>(bytes[name.size()]))),
            fmt::format("version {} ('{}')", static_cast<int>(kMagic.back()), kMagic.back()));
  in.skip(kMagic.size());
  const auto size = in.number<std::uint64_t>("the file's size");
  if (size != bytes.size() || size < kSizeAt + 2 * kWord)
    in.fail(kSizeAt, fmt::format("a file of {} bytes that says it has {}", bytes.size(), size),
            "its size there, and all of it");
  const std::size_t end = bytes.size() - kWord;
  std::uint64_t stored = 0;
  std::memcpy(&stored, bytes.data() + end, kWord);
  if (const std::uint64_t sum = checksum(bytes.substr(0, end)); sum != stored)
    in.fail(end, fmt::format("checksum {:016x}", stored), fmt::format("{:016x}", sum));
  in.drop_last(kWord);
}

void read_history(Reader& in, History& history) {
  // a member added to History must be stored: this stops compiling
  auto& [lambda, force, suggested_dt, last_dt, contacts] = history;
  lambda = in.vector("lambda");
  force = in.vector("force");
  suggested_dt = in.finite("suggested dt");
  last_dt = in.finite("last dt");
  const std::size_t at = in.at();
  contacts = in.vector("contacts");
  if (contacts.size() % 6 != 0)
    in.fail(at, fmt::format("{} numbers of contacts", contacts.size()), "6 per contact");
}

void read_state(Reader& in, State& state) {
  auto& [t, q, v] = state;
  t = in.finite("t");
  q = in.vector("q");
  const std::size_t at = in.at();
  v = in.vector("v");
  if (v.size() % 3 != 0 || q.size() < v.size())
    in.fail(at, fmt::format("{} velocities beside {} coordinates", v.size(), q.size()),
            "3 velocities per node and as many coordinates or more");
}

std::vector<FilePosition> read_files(Reader& in) {
  std::vector<FilePosition> files;
  const std::size_t count = in.count("number of files", 2 * kWord);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = in.at();
    FilePosition file;
    file.name = in.text("length of a file's name");
    file.length = in.not_negative("length of a file");
    const bool known = std::any_of(files.begin(), files.end(),
                                   [&](const FilePosition& other) { return other.name == file.name; });
    if (known) in.fail(at, "file '" + file.name + "' for the second time", "every file once");
    files.push_back(std::move(file));
  }
  return files;
}

std::string to_bytes(const Checkpoint& checkpoint) {
  const auto& [scene_hash, frame, step, state, history, files] = checkpoint;
  const auto& [t, q, v] = state;
  const auto& [lambda, force, suggested_dt, last_dt, contacts] = history;
  Writer out;
  out.bytes = kMagic;
  out.add(std::uint64_t{0});
  out.add(scene_hash);
  out.add(frame);
  out.add(step);
  out.add(t);
  out.add(q);
  out.add(v);
  out.add(lambda);
  out.add(force);
  out.add(suggested_dt);
  out.add(last_dt);
  out.add(contacts);
  out.add(static_cast<std::int64_t>(files.size()));
  for (const FilePosition& file : files) {
    out.add(file.name);
    out.add(file.length);
  }
  const std::uint64_t size = out.bytes.size() + kWord;
  std::memcpy(out.bytes.data() + kSizeAt, &size, kWord);
  out.add(checksum(out.bytes));
  return std::move(out.bytes);
}

}  // namespace

Checkpoint parse_checkpoint(std::string_view bytes, const std::string& place) {
  Reader in(bytes, place);
  open_envelope(in);
  Checkpoint checkpoint;
  checkpoint.scene_hash = in.number<std::uint64_t>("scene hash");
  checkpoint.frame = in.not_negative("frame");
  checkpoint.step = in.not_negative("step");
  read_state(in, checkpoint.state);
  read_history(in, checkpoint.history);
  checkpoint.files = read_files(in);
  if (in.left() > 0) in.fail(in.at(), fmt::format("{} bytes left", in.left()), "the checksum");
  return checkpoint;
}

void write_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  const std::string bytes = to_bytes(checkpoint);
  try {
    (void)parse_checkpoint(bytes, "checkpoint");
  } catch (const InputError& error) {
    throw MisuseError(std::string("a checkpoint that could not be read again: ") + error.what());
  }
  write_file(path, bytes);
}

Checkpoint read_checkpoint(const std::filesystem::path& path) {
  return parse_checkpoint(read_file(path), path.string());
}

void require_checkpoint_of(const Scene& scene, std::uint64_t scene_hash, const Checkpoint& checkpoint,
                           const std::string& place) {
  const System& s = scene.model.system;
  if (checkpoint.scene_hash != scene_hash)
    throw InputError(fmt::format("{}: of a scene with hash {:016x}, expected {:016x} of '{}'", place,
                                 checkpoint.scene_hash, scene_hash, scene.model.name));
  const auto require_size = [&](const char* what, const VectorXd& values, Eigen::Index size,
                                bool may_be_empty) {
    if (values.size() != size && !(may_be_empty && values.size() == 0))
      throw InputError(fmt::format("{}: {} has {} numbers, expected {} as in '{}'", place, what,
                                   values.size(), size, scene.model.name));
  };
  require_size("q", checkpoint.state.q, s.position_size(), false);
  require_size("v", checkpoint.state.v, 3 * s.nodes, false);
  require_size("lambda", checkpoint.history.lambda, s.rows, true);
  require_size("force", checkpoint.history.force, 3 * s.nodes, true);
}

}  // namespace feder::experiments
